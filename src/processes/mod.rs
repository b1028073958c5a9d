//! Processes that the program starts, and what processes have used, as the kernel knows it.

mod child;

pub use child::Process;

use std::fs;

/// Whether a program is a file, or the name of one in a folder of `PATH`.
pub(crate) fn on_path(program: &str) -> bool {
    if program.contains('/') {
        return std::path::Path::new(program).is_file();
    }
    std::env::var_os("PATH").is_some_and(|folders| {
        std::env::split_paths(&folders).any(|folder| folder.join(program).is_file())
    })
}

/// Largest resident memory so far of the process with this number, bytes; `None` if it is gone.
pub fn peak_memory(process: u32) -> Option<f64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024.0)
}

/// CPU seconds of a process and those that it has started and that are still there.
pub fn cpu_seconds(process: u32) -> f64 {
    let of_thread = |task: &fs::DirEntry| {
        let nanoseconds = fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
        let first = nanoseconds.split(' ').next();
        first.and_then(|n| n.parse::<f64>().ok()).unwrap_or(0.0) * 1e-9
    };
    let own: f64 = threads(process).iter().map(of_thread).sum();
    own + children(process).into_iter().map(cpu_seconds).sum::<f64>()
}

/// Sum of the largest resident memories of a process and those that it has started and that are still there, bytes.
pub fn peak_memory_of_all(process: u32) -> f64 {
    let own = peak_memory(process).unwrap_or(0.0);
    own + (children(process).into_iter())
        .map(peak_memory_of_all)
        .sum::<f64>()
}

/// Memory of this machine, bytes.
pub fn machine_memory() -> Option<f64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("MemTotal:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024.0)
}

fn threads(process: u32) -> Vec<fs::DirEntry> {
    let tasks = fs::read_dir(format!("/proc/{process}/task"));
    tasks.into_iter().flatten().flatten().collect()
}

fn children(process: u32) -> Vec<u32> {
    let of_thread = |task: &fs::DirEntry| {
        let text = fs::read_to_string(task.path().join("children")).unwrap_or_default();
        let ids: Vec<u32> = text
            .split_whitespace()
            .filter_map(|id| id.parse().ok())
            .collect();
        ids
    };
    threads(process).iter().flat_map(of_thread).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::process::{Command, Stdio};

    #[test]
    fn a_child_counts_with_its_parent() {
        // The shell waits for its child, which waits for the end of its input.
        let mut shell = Command::new("sh")
            .args(["-c", "cat; true"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        // Until the first line comes back, the child may be a copy of the shell, which is larger.
        let mut line = [0; 2];
        shell.stdin.as_mut().unwrap().write_all(b"a\n").unwrap();
        shell
            .stdout
            .as_mut()
            .unwrap()
            .read_exact(&mut line)
            .unwrap();
        let child = children(shell.id())[0];
        let both = peak_memory_of_all(shell.id());
        let [own, its] = [shell.id(), child].map(|id| peak_memory(id).unwrap());
        assert!(own > 1e5 && its > 1e5, "{own} {its}");
        assert!(
            (0.9..=1.1).contains(&((both - own) / its)),
            "{own} {its} {both}"
        );
        drop(shell.stdin.take());
        shell.wait().unwrap();
        assert_eq!((peak_memory(child), cpu_seconds(child)), (None, 0.0));
        assert!(cpu_seconds(std::process::id()) > 0.0);
    }
}
