//! Numbers of a mesh of Gmsh, as words or as bytes.

use crate::files::{Fault, fault};

/// Where in the file one reads.
pub struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Line of what was read last, counted from 1; of a binary file it means nothing.
    pub line: usize,
    pub is_binary: bool,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes),
            at: 0,
            line: 0,
            is_binary: false,
        }
    }

    /// What is wrong, with the place.
    pub fn wrong(&self, reason: &dyn std::fmt::Display) -> Fault {
        match self.is_binary {
            true => fault!("byte {}: {reason}", self.at),
            false => Fault::at(self.line, reason),
        }
    }

    /// The next line, without what ends it.
    pub fn text(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest
            .iter()
            .position(|byte| *byte == b'\n')
            .unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        self.line += 1;
        Some(String::from_utf8_lossy(&rest[..length]).trim().to_owned())
    }

    /// The next word, on whatever line.
    fn word(&mut self) -> Result<&'a str, Fault> {
        let mut is_new =
            self.line == 0 || self.at == 0 || self.bytes.get(self.at - 1) == Some(&b'\n');
        while let Some(byte) = self
            .bytes
            .get(self.at)
            .filter(|byte| byte.is_ascii_whitespace())
        {
            self.line += usize::from(is_new);
            is_new = *byte == b'\n';
            self.at += 1;
        }
        self.line += usize::from(is_new);
        let rest = &self.bytes[self.at..];
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        if length == 0 {
            return Err("it ends before it is complete".into());
        }
        self.at += length;
        std::str::from_utf8(&rest[..length]).map_err(|_| self.wrong(&"expected a number"))
    }

    fn number<T: std::str::FromStr>(&mut self) -> Result<T, Fault> {
        let word = self.word()?;
        let number = word.parse();
        number.map_err(|_| self.wrong(&format_args!("expected a number, found {word:?}")))
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let taken = self
            .bytes
            .get(self.at..self.at + N)
            .and_then(|bytes| bytes.try_into().ok());
        self.at += N;
        taken.ok_or_else(|| "it ends before it is complete".into())
    }

    /// A number of 4 bytes.
    pub fn int(&mut self) -> Result<i64, Fault> {
        match self.is_binary {
            true => Ok(i64::from(i32::from_le_bytes(self.take()?))),
            false => self.number(),
        }
    }

    /// A number of 8 bytes.
    pub fn size(&mut self) -> Result<usize, Fault> {
        match self.is_binary {
            true => usize::try_from(u64::from_le_bytes(self.take()?)).map_err(|e| self.wrong(&e)),
            false => self.number(),
        }
    }

    pub fn sizes<const N: usize>(&mut self) -> Result<[usize; N], Fault> {
        let mut all = [0; N];
        for size in &mut all {
            *size = self.size()?;
        }
        Ok(all)
    }

    pub fn real(&mut self) -> Result<f64, Fault> {
        let real = match self.is_binary {
            true => f64::from_le_bytes(self.take()?),
            false => self.number()?,
        };
        match real.is_finite() {
            true => Ok(real),
            false => Err(self.wrong(&format_args!("expected a finite number, found {real}"))),
        }
    }

    pub fn point(&mut self) -> Result<[f64; 3], Fault> {
        Ok([self.real()?, self.real()?, self.real()?])
    }

    /// How many follow, at most as many as bytes are left.
    pub fn count(&mut self, count: i64) -> Result<usize, Fault> {
        let left = self.bytes.len().saturating_sub(self.at);
        match usize::try_from(count).ok().filter(|count| *count <= left) {
            Some(count) => Ok(count),
            None => Err(self.wrong(&format_args!("{count} entries are announced, more than there is room for: it is cut off or damaged"))),
        }
    }

    /// Leaves the line, if words are read.
    pub fn end_line(&mut self) {
        let is_amid = self.at > 0 && self.bytes.get(self.at - 1) != Some(&b'\n');
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        if is_amid && !self.is_binary {
            let length = rest.iter().position(|byte| *byte == b'\n');
            self.at += length.map_or(rest.len(), |length| length + 1);
        }
    }

    /// Goes past the end of a section, whatever stands in it.
    pub fn skip(&mut self, section: &str) {
        let end = format!("$End{section}");
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let found = rest
            .windows(end.len())
            .position(|window| window == end.as_bytes());
        let length = found.map_or(rest.len(), |place| place + end.len());
        self.line += rest[..length].iter().filter(|byte| **byte == b'\n').count();
        self.at += length;
        if !self.is_binary {
            self.end_line();
        }
    }
}
