//! At most one process works in the folder of a run.

use super::Failure;
use rustix::fs::{FlockOperation, Mode, OFlags, flock};
use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::Path;
use std::time::{Duration, Instant};

/// How long the solver of a driver that was killed may take to end.
const LAST_BREATH: Duration = Duration::from_secs(15);

/// Held while this value lives, *and* while a solver lives that was started meanwhile: the lock belongs to the open
/// file, which the solvers inherit. The kernel releases it with the last of them, however they end, so it is never
/// stale; what is written in the file only serves to name the holder.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

impl Lock {
    /// Takes the lock, or says who has it. Waits a while for the solver of a driver that has gone already.
    pub fn take(path: &Path) -> Result<Self, Failure> {
        let failed =
            |error: io::Error| Failure::Input(format!("cannot lock {}: {error}", path.display()));
        // Not closed on exec.
        let flags = OFlags::RDWR | OFlags::CREATE;
        let file = rustix::fs::open(path, flags, Mode::from_raw_mode(0o644));
        let mut file = File::from(file.map_err(|e| failed(e.into()))?);
        let since = Instant::now();
        loop {
            match flock(&file, FlockOperation::NonBlockingLockExclusive) {
                Ok(()) => break,
                Err(rustix::io::Errno::WOULDBLOCK) => {}
                Err(error) => return Err(failed(error.into())),
            }
            let holder = Holder::read(&mut file).map_err(failed)?;
            if holder.may_live() || since.elapsed() > LAST_BREATH {
                return Err(Failure::Input(format!(
                    "{} is running in {}; wait for it, end it, or choose another folder with --out",
                    holder.0,
                    path.parent().unwrap_or(path).display()
                )));
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        Holder::this().write(&mut file).map_err(failed)?;
        Ok(Self { _file: file })
    }
}

impl Lock {
    /// The process that has the lock, if there is one.
    pub fn holder(path: &Path) -> Option<String> {
        let mut file = File::open(path).ok()?;
        match flock(&file, FlockOperation::NonBlockingLockShared) {
            Err(rustix::io::Errno::WOULDBLOCK) => Some(Holder::read(&mut file).ok()?.0),
            _ => None,
        }
    }
}

/// `process 4711 on host`.
struct Holder(String);

impl Holder {
    fn this() -> Self {
        Self(format!("process {} on {}", std::process::id(), host()))
    }

    fn read(file: &mut File) -> io::Result<Self> {
        let mut text = String::new();
        file.rewind()?;
        file.take(200).read_to_string(&mut text)?;
        let text = text.trim();
        Ok(Self(if text.is_empty() {
            "another process".into()
        } else {
            text.to_owned()
        }))
    }

    fn write(&self, file: &mut File) -> io::Result<()> {
        file.set_len(0)?;
        file.rewind()?;
        writeln!(file, "{}", self.0)
    }

    /// Not if it was a process on this machine that has gone.
    fn may_live(&self) -> bool {
        let words: Vec<_> = self.0.split_whitespace().collect();
        match words[..] {
            ["process", number, "on", its_host] if its_host == host() => {
                Path::new("/proc").join(number).exists()
            }
            _ => true,
        }
    }
}

fn host() -> String {
    let name = rustix::system::uname();
    name.nodename().to_string_lossy().into_owned()
}
