//! Carries whole messages between the driver and the fluid: over a Unix-domain socket, or as files in a folder.

use super::protocol::{Expected, FRAME_SIZE, FromFluid, ProtocolError, WireFrame};
use std::fs;
use std::io::{self, Read, Write};
use std::os::unix::fs::{DirBuilderExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often a waiting driver looks at the clock, the interrupt flag and the solver's process.
const GLANCE: Duration = Duration::from_millis(50);
/// Bytes that are read before more memory is set aside: an announced length alone reserves nothing.
const CHUNK: usize = 1 << 16;

/// Why no message could be carried.
#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    /// The system refused.
    #[error("{action}: {source}")]
    Io {
        /// What was being done.
        action: String,
        /// Why it failed.
        source: io::Error,
    },
    /// The fluid closed its end.
    #[error("the fluid has closed the connection")]
    Closed,
    /// The fluid's process has ended.
    #[error("the fluid's process has ended")]
    Ended,
    /// The fluid did not answer.
    #[error("no answer from the fluid within {:.0} s", .0.as_secs_f64())]
    TimedOut(Duration),
    /// The user ended the run.
    #[error("interrupted")]
    Interrupted,
    /// The fluid sent what it must not send.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
}

fn io_error(action: impl Into<String>) -> impl FnOnce(io::Error) -> TransportError {
    let action = action.into();
    |source| TransportError::Io { action, source }
}

/// What ends the wait for the fluid.
pub struct Patience<'a> {
    limit: Duration,
    since: Instant,
    interrupt: &'a AtomicBool,
    ended: &'a mut dyn FnMut() -> bool,
}

impl<'a> Patience<'a> {
    /// Waits until `limit` is over, `interrupt` is set, or `ended` says that the solver's process is no more.
    pub fn new(
        limit: Duration,
        interrupt: &'a AtomicBool,
        ended: &'a mut dyn FnMut() -> bool,
    ) -> Self {
        Self {
            limit,
            since: Instant::now(),
            interrupt,
            ended,
        }
    }

    fn glance(&mut self) -> Result<(), TransportError> {
        if self.interrupt.load(Ordering::Relaxed) {
            Err(TransportError::Interrupted)
        } else if (self.ended)() {
            Err(TransportError::Ended)
        } else if self.since.elapsed() > self.limit {
            Err(TransportError::TimedOut(self.limit))
        } else {
            Ok(())
        }
    }
}

/// A place where the fluid can find the driver.
pub enum Listener {
    /// A socket in a private folder that goes once the fluid has connected.
    Socket {
        /// The folder, 0700.
        folder: tempfile::TempDir,
        /// The socket in it.
        listener: UnixListener,
    },
    /// A folder for files.
    Files {
        /// The folder, 0700.
        folder: PathBuf,
    },
}

impl Listener {
    /// A Unix-domain socket. It lies in the system's folder for temporary files since the path of a socket is short.
    pub fn socket() -> Result<Self, TransportError> {
        let folder = tempfile::Builder::new()
            .prefix("fsi-driver-")
            .permissions(fs::Permissions::from_mode(0o700)) // nobody else can connect
            .tempdir()
            .map_err(io_error("cannot make a private folder for the socket"))?;
        let path = folder.path().join("fluid");
        let listener = UnixListener::bind(&path)
            .map_err(io_error(format!("cannot listen at {}", path.display())))?;
        listener
            .set_nonblocking(true)
            .map_err(io_error("cannot configure the socket"))?;
        Ok(Listener::Socket { folder, listener })
    }

    /// An empty folder `folder` for files, made again.
    pub fn files(folder: &Path) -> Result<Self, TransportError> {
        match fs::remove_dir_all(folder) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(io_error(format!("cannot empty {}", folder.display()))(
                    error,
                ));
            }
            _ => {}
        }
        let mut builder = fs::DirBuilder::new();
        builder
            .mode(0o700)
            .create(folder)
            .map_err(io_error(format!("cannot make {}", folder.display())))?;
        Ok(Listener::Files {
            folder: folder.to_owned(),
        })
    }

    /// Where the fluid must look.
    pub fn address(&self) -> PathBuf {
        match self {
            Listener::Socket { folder, .. } => folder.path().join("fluid"),
            Listener::Files { folder } => folder.clone(),
        }
    }

    /// Waits for the fluid.
    pub fn accept(self, patience: &mut Patience) -> Result<Transport, TransportError> {
        match self {
            Listener::Files { folder } => Ok(Transport::Files(FileTransport {
                folder,
                sent: 0,
                received: 0,
            })),
            Listener::Socket { folder, listener } => loop {
                match listener.accept() {
                    Ok((stream, _)) => {
                        stream
                            .set_nonblocking(false)
                            .and_then(|()| stream.set_read_timeout(Some(GLANCE)))
                            .and_then(|()| stream.set_write_timeout(Some(GLANCE)))
                            .map_err(io_error("cannot configure the socket"))?;
                        // Connected, nobody needs to find the socket any more: a run that is killed leaves nothing.
                        drop(folder);
                        return Ok(Transport::Socket(Socket { stream }));
                    }
                    Err(error) if is_pause(&error) => {
                        patience.glance()?;
                        std::thread::sleep(Duration::from_millis(5));
                    }
                    Err(error) => {
                        return Err(io_error("cannot accept the fluid's connection")(error));
                    }
                }
            },
        }
    }
}

/// A connection to the fluid.
pub enum Transport {
    /// Over a Unix-domain socket.
    Socket(Socket),
    /// Over files in a folder.
    Files(FileTransport),
}

impl Transport {
    /// Sends a whole message.
    pub fn send(&mut self, message: &[u8], patience: &mut Patience) -> Result<(), TransportError> {
        match self {
            Transport::Socket(socket) => socket.send(message, patience),
            Transport::Files(files) => files.send(message),
        }
    }

    /// Closes the connection; one of files ends with the driver's process only.
    pub(super) fn close(&mut self) {
        if let Transport::Socket(socket) = self {
            // It may be closed from the other side already.
            let _ = socket.stream.shutdown(std::net::Shutdown::Both);
        }
    }

    /// Receives the expected message, or the fluid's failure.
    pub fn receive(
        &mut self,
        expected: Expected,
        patience: &mut Patience,
    ) -> Result<FromFluid, TransportError> {
        let (frame, payload) = match self {
            Transport::Socket(socket) => socket.receive(expected, patience)?,
            Transport::Files(files) => files.receive(expected, patience)?,
        };
        match expected.decode(frame.kind, &payload)? {
            FromFluid::Failure(text) => Err(ProtocolError::Failure(text).into()),
            message => Ok(message),
        }
    }
}

fn is_pause(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted
    )
}

/// A connected socket.
pub struct Socket {
    stream: UnixStream,
}

impl Socket {
    fn send(&mut self, message: &[u8], patience: &mut Patience) -> Result<(), TransportError> {
        let mut rest = message;
        while !rest.is_empty() {
            match self.stream.write(rest) {
                Ok(n) => rest = &rest[n..],
                Err(error) if is_pause(&error) => patience.glance()?,
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                    return Err(TransportError::Closed);
                }
                Err(error) => return Err(io_error("cannot write to the fluid")(error)),
            }
        }
        Ok(())
    }

    fn read(
        &mut self,
        mut bytes: &mut [u8],
        patience: &mut Patience,
    ) -> Result<(), TransportError> {
        while !bytes.is_empty() {
            match self.stream.read(bytes) {
                Ok(0) => return Err(TransportError::Closed),
                Ok(n) => bytes = &mut bytes[n..],
                Err(error) if is_pause(&error) => patience.glance()?,
                Err(error) if error.kind() == io::ErrorKind::ConnectionReset => {
                    return Err(TransportError::Closed);
                }
                Err(error) => return Err(io_error("cannot read from the fluid")(error)),
            }
        }
        Ok(())
    }

    fn receive(
        &mut self,
        expected: Expected,
        patience: &mut Patience,
    ) -> Result<(WireFrame, Vec<u8>), TransportError> {
        let mut head = [0; FRAME_SIZE];
        self.read(&mut head, patience)?;
        let frame = WireFrame::decode(&head)?;
        expected.check(frame)?;
        let length = frame.length as usize; // at most MAX_HELLO
        let mut payload = Vec::new();
        while payload.len() < length {
            let done = payload.len();
            payload.resize(length.min(done + CHUNK), 0);
            self.read(&mut payload[done..], patience)?;
        }
        Ok((frame, payload))
    }
}

/// A folder in which each message is a file, `00000001.driver` and `00000001.fluid` being the first of each side.
pub struct FileTransport {
    folder: PathBuf,
    sent: u64,
    received: u64,
}

impl FileTransport {
    fn send(&mut self, message: &[u8]) -> Result<(), TransportError> {
        self.sent += 1;
        let path = self.folder.join(format!("{:08}.driver", self.sent));
        let partial = path.with_extension("driver.partial");
        // The fluid looks for the final name only, which appears with the last byte already in place.
        fs::write(&partial, message)
            .and_then(|()| fs::rename(&partial, &path))
            .map_err(io_error(format!("cannot write {}", path.display())))
    }

    fn receive(
        &mut self,
        expected: Expected,
        patience: &mut Patience,
    ) -> Result<(WireFrame, Vec<u8>), TransportError> {
        self.received += 1;
        let path = self.folder.join(format!("{:08}.fluid", self.received));
        let reading = || format!("cannot read {}", path.display());
        // Quick answers are met quickly, long waits cost next to nothing.
        let mut pause = Duration::from_micros(50);
        let mut last_glance = Instant::now();
        let mut file = loop {
            match fs::File::open(&path) {
                Ok(file) => break file,
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    if last_glance.elapsed() > GLANCE {
                        match patience.glance() {
                            // Its last lines may have come since.
                            Err(TransportError::Ended) if path.exists() => continue,
                            glanced => glanced?,
                        }
                        last_glance = Instant::now();
                    }
                    std::thread::sleep(pause);
                    pause = (pause * 5 / 4).min(Duration::from_millis(5));
                }
                Err(error) => return Err(io_error(reading())(error)),
            }
        };
        let found = file.metadata().map_err(io_error(reading()))?.len();
        let mut head = [0; FRAME_SIZE];
        file.read_exact(&mut head).map_err(io_error(reading()))?;
        let frame = WireFrame::decode(&head)?;
        expected.check(frame)?;
        if found != FRAME_SIZE as u64 + frame.length {
            let expected = format!("{} as its frame announces", frame.length);
            let found = found.saturating_sub(FRAME_SIZE as u64);
            return Err(ProtocolError::Length {
                kind: frame.kind,
                expected,
                found,
            }
            .into());
        }
        let mut payload = Vec::with_capacity(frame.length as usize); // the file has that many
        file.read_to_end(&mut payload)
            .map_err(io_error(reading()))?;
        fs::remove_file(&path).map_err(io_error(reading()))?;
        Ok((frame, payload))
    }
}

#[cfg(test)]
mod tests;
