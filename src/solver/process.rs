//! A solver as a child process: started by its `run.sh`, watched, stopped on
//! request, with what it cost.
//!
//! CPU time is read from `/proc/PID/stat` after the child has ended and before
//! it is waited for (children that it has waited for itself included), peak
//! memory from `/proc/PID/status` while it runs. Where there is no `/proc`
//! both are unknown.

use super::SolverError;
use crate::num::Job;
use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

/// How often the child is looked at.
const LOOK: Duration = Duration::from_millis(20);
/// How long MPI may take to stop its ranks before it is killed.
const PATIENCE: Duration = Duration::from_secs(5);
/// How long a program may take to tell its version (YADE loads for seconds from slow disks).
const PROBE: Duration = Duration::from_secs(30);
/// Lines of output that are kept.
const TAIL: usize = 400;
/// Clock ticks a second in `/proc/PID/stat`: 100 on every Linux.
const TICKS: f64 = 100.0;

/// What to start and how to follow it.
pub struct Command<'a> {
    /// Folder of the deck.
    pub folder: &'a Path,
    /// Environment variable by which `run.sh` takes another program.
    pub variable: &'a str,
    /// The program.
    pub program: &'a Path,
    /// Name for people.
    pub solver: &'static str,
    /// Steps that the run takes.
    pub steps: u64,
    /// Reads the step number from a line of output, if it tells one.
    pub step_of: fn(&str) -> Option<u64>,
    /// MPI ranks; more than one are stopped through `mpirun`.
    pub ranks: usize,
}

/// How a child ended.
#[derive(Debug, Clone)]
pub struct Ended {
    /// True for exit status 0.
    pub success: bool,
    /// True if it was stopped because the job was cancelled.
    pub cancelled: bool,
    /// Exit status for people.
    pub status: String,
    /// Last lines of its output, standard output and error together.
    pub tail: Vec<String>,
    /// CPU seconds, where known.
    pub cpu_seconds: Option<f64>,
    /// Wall-clock seconds from start to end.
    pub wall_seconds: f64,
    /// Largest resident memory seen, bytes (one rank only), where known.
    pub peak_bytes: Option<u64>,
}

impl Ended {
    /// The last `count` lines of output.
    pub fn last_lines(&self, count: usize) -> String {
        let lines: Vec<&str> =
            self.tail.iter().map(|line| line.trim_end()).filter(|line| !line.is_empty()).collect();
        lines[lines.len().saturating_sub(count)..].join("\n")
    }

    /// The last line of output that holds `marker`.
    pub fn line_with(&self, marker: &str) -> Option<&str> {
        self.tail.iter().rev().find(|line| line.contains(marker)).map(String::as_str)
    }
}

impl Command<'_> {
    /// Runs `sh run.sh` in the folder until it ends or `job` is cancelled.
    pub fn run(&self, job: &Job) -> Result<Ended, SolverError> {
        let start = Instant::now();
        let script = self.folder.join("run.sh");
        let mut child = std::process::Command::new("sh")
            .arg("run.sh")
            .current_dir(self.folder)
            .env(self.variable, self.program)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(SolverError::io(&script))?;
        let (sender, lines) = channel();
        for stream in [
            child.stdout.take().map(|s| Box::new(s) as Box<dyn Read + Send>),
            child.stderr.take().map(|s| Box::new(s) as Box<dyn Read + Send>),
        ] {
            follow(stream, sender.clone());
        }
        drop(sender);
        self.watch(child, &lines, start, job).map_err(SolverError::io(&script))
    }

    fn watch(
        &self,
        mut child: Child,
        lines: &Receiver<String>,
        start: Instant,
        job: &Job,
    ) -> std::io::Result<Ended> {
        let mut tail = VecDeque::new();
        let (mut cancelled, mut peak) = (false, None);
        let mut usage = None;
        let status = loop {
            self.take(lines, &mut tail, job);
            peak = peak.max(resident_peak(child.id()));
            match stat(child.id()) {
                // Ended and not yet waited for: the times are final.
                Some(stat) if stat.ended => {
                    usage = Some(stat.cpu_seconds);
                    break child.wait()?;
                }
                Some(_) => {}
                None => {
                    if let Some(status) = child.try_wait()? {
                        break status;
                    }
                }
            }
            if job.is_cancelled() && !cancelled {
                cancelled = true;
                self.stop(&mut child)?;
            }
            std::thread::sleep(LOOK);
        };
        // Both pipes close with the child; what is left in them is taken now.
        while let Ok(line) = lines.recv_timeout(Duration::from_secs(1)) {
            self.keep(line, &mut tail, job);
        }
        Ok(Ended {
            success: status.success(),
            cancelled,
            status: status.to_string(),
            tail: tail.into(),
            cpu_seconds: usage,
            wall_seconds: start.elapsed().as_secs_f64(),
            peak_bytes: peak.filter(|_| self.ranks == 1),
        })
    }

    /// LIGGGHTS swallows SIGTERM outside its step loop, so one process is
    /// killed; `mpirun` needs SIGTERM to take its ranks with it.
    fn stop(&self, child: &mut Child) -> std::io::Result<()> {
        if self.ranks > 1 {
            let asked = std::process::Command::new("kill").arg(child.id().to_string()).status();
            let since = Instant::now();
            while asked.is_ok() && since.elapsed() < PATIENCE {
                if stat(child.id()).is_none_or(|stat| stat.ended) {
                    return Ok(());
                }
                std::thread::sleep(LOOK);
            }
        }
        child.kill()
    }

    fn take(&self, lines: &Receiver<String>, tail: &mut VecDeque<String>, job: &Job) {
        while let Ok(line) = lines.try_recv() {
            self.keep(line, tail, job);
        }
    }

    fn keep(&self, line: String, tail: &mut VecDeque<String>, job: &Job) {
        if let Some(step) = (self.step_of)(&line) {
            job.report(self.solver, step.min(self.steps), self.steps);
        }
        if tail.len() == TAIL {
            tail.pop_front();
        }
        tail.push_back(line);
    }
}

/// Sends every line of `stream`; bytes that are no UTF-8 are replaced.
fn follow(stream: Option<Box<dyn Read + Send>>, sender: Sender<String>) {
    let Some(stream) = stream else { return };
    std::thread::spawn(move || {
        for line in BufReader::new(stream).split(b'\n') {
            let Ok(line) = line else { return };
            if sender.send(String::from_utf8_lossy(&line).into_owned()).is_err() {
                return;
            }
        }
    });
}

struct Stat {
    ended: bool,
    cpu_seconds: f64,
}

/// State and times of a process and of the children it has waited for.
fn stat(pid: u32) -> Option<Stat> {
    parse_stat(&std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?)
}

fn parse_stat(text: &str) -> Option<Stat> {
    // The second field is the name in brackets and may hold blanks: count from its end.
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks: f64 =
        fields.get(11..15)?.iter().map(|field| field.parse::<f64>().unwrap_or(0.0)).sum();
    Some(Stat { ended: matches!(*fields.first()?, "Z" | "X"), cpu_seconds: ticks / TICKS })
}

/// Largest resident memory of a running process so far, bytes.
fn resident_peak(pid: u32) -> Option<u64> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

/// The program that `variable` names, or else `name` on `PATH`.
pub fn program(variable: &str, name: &str) -> Option<PathBuf> {
    let wanted = std::env::var_os(variable).filter(|value| !value.is_empty());
    let wanted = wanted.map_or_else(|| PathBuf::from(name), PathBuf::from);
    if wanted.components().count() > 1 {
        // The deck is run in another folder, so the path must not depend on this one.
        return wanted.is_file().then(|| std::path::absolute(&wanted).ok()).flatten();
    }
    std::env::split_paths(&std::env::var_os("PATH")?)
        .map(|folder| folder.join(&wanted))
        .find(|path| path.is_file())
}

/// What `program` prints after `marker` when called with `arguments`, to the end of the line;
/// `None` also if it has not ended after [`PROBE`].
pub fn says(program: &Path, arguments: &[&str], marker: &str) -> Option<String> {
    says_within(program, arguments, marker, PROBE)
}

fn says_within(
    program: &Path,
    arguments: &[&str],
    marker: &str,
    patience: Duration,
) -> Option<String> {
    let mut child = std::process::Command::new(program)
        .args(arguments)
        .env("OMPI_MCA_ess_singleton_isolated", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .ok()?;
    let (sender, lines) = channel();
    follow(child.stdout.take().map(|s| Box::new(s) as Box<dyn Read + Send>), sender.clone());
    follow(child.stderr.take().map(|s| Box::new(s) as Box<dyn Read + Send>), sender);
    let start = Instant::now();
    while child.try_wait().ok()?.is_none() {
        if start.elapsed() > patience {
            // It may have ended in between; either way it is waited for, and no use.
            let _ = child.kill();
            let _ = child.wait();
            return None;
        }
        std::thread::sleep(LOOK);
    }
    let mut said = None;
    // Both pipes close with the child; one that a child of its own holds open is not waited for.
    while let Ok(line) = lines.recv_timeout(Duration::from_secs(1)) {
        let rest = line.split_once(marker).map(|(_, rest)| rest.trim().to_owned());
        said = said.or(rest);
    }
    said
}

/// Removes old output files, so that nothing old is ever read as new.
pub fn remove(folder: &Path, names: &[&str]) -> Result<(), SolverError> {
    for name in names {
        let path = folder.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(SolverError::Io { path, source: error });
            }
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stat_lines_are_read_past_odd_names() {
        let text = "17 (a b) c) Z 1 1 1 0 -1 4 0 0 0 0 250 50 10 5 20 0 1 0";
        let stat = parse_stat(text).expect("a stat line");
        assert!(stat.ended);
        assert_eq!(stat.cpu_seconds, 3.15);
    }

    fn run(text: &str, job: &Job) -> Ended {
        let room = tempfile::tempdir().expect("temporary folder");
        std::fs::write(room.path().join("run.sh"), text).expect("written");
        Command {
            folder: room.path(),
            variable: "RIPRAP_TEST_PROGRAM",
            program: Path::new("/nowhere/solver"),
            solver: "test",
            steps: 10,
            step_of: |line| line.strip_prefix("step ")?.parse().ok(),
            ranks: 1,
        }
        .run(job)
        .expect("sh starts")
    }

    #[test]
    fn output_status_and_program_arrive() {
        let ended =
            run("echo step 3; echo bad >&2; echo $RIPRAP_TEST_PROGRAM; exit 7", &Job::quiet());
        assert!(!ended.success && !ended.cancelled);
        assert!(ended.status.contains('7'), "{}", ended.status);
        for text in ["step 3", "bad", "/nowhere/solver"] {
            assert!(ended.line_with(text).is_some(), "{:?}", ended.tail);
        }
    }

    #[test]
    fn a_program_that_hangs_tells_no_version() {
        let sh = |text: &str| {
            let start = Instant::now();
            let short = Duration::from_millis(300);
            let said = says_within(Path::new("/bin/sh"), &["-c", text], "Version ", short);
            assert!(start.elapsed() < Duration::from_secs(20));
            said
        };
        assert_eq!(sh("echo a; echo Version 3 >&2").as_deref(), Some("3"));
        assert_eq!(sh("echo Version 3; exec sleep 60"), None);
    }

    #[test]
    fn cancelled_children_are_killed() {
        use std::sync::{Arc, atomic::AtomicBool};
        let job = Job::new(1, Arc::new(crate::num::job::Silent), Arc::new(AtomicBool::new(true)));
        let ended = run("exec sleep 30", &job);
        assert!(ended.cancelled && !ended.success);
        assert!(ended.wall_seconds < 10.0);
    }
}
