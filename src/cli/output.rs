//! The screen: results on standard output, messages and progress on standard
//! error, endings as exit codes.

use super::arguments::Arguments;
use crate::clump::ClumpError;
use crate::dem::DemError;
use crate::format::FormatError;
use crate::geometry::GeometryError;
use crate::num::job::{Job, Progress};
use crate::report::ReportError;
use crate::scene::SceneError;
use crate::scene::road::{Road, RoadError};
use crate::shape::ShapeError;
use crate::solver::SolverError;
use clap::ColorChoice;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// Why a verb ended without success.
#[derive(Debug)]
pub enum Ending {
    /// The work failed or a comparison is outside its tolerance: exit code 1.
    Work(String),
    /// The input is wrong: exit code 2.
    Input(String),
    /// An outside solver is missing or failed: exit code 3.
    Solver(String),
    /// Stopped by Ctrl-C: exit code 130.
    Cancelled(String),
    /// Nobody reads any more: quiet success.
    BrokenPipe,
}

impl From<std::io::Error> for Ending {
    fn from(error: std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::BrokenPipe {
            return Self::BrokenPipe;
        }
        Self::Work(error.to_string())
    }
}

impl From<RoadError> for Ending {
    fn from(error: RoadError) -> Self {
        match error {
            RoadError::Scene(error) => error.into(),
            RoadError::Format(error) => error.into(),
            RoadError::Clump(error) => error.into(),
            RoadError::Dem(error) => error.into(),
            error @ RoadError::Paused { .. } => Self::Cancelled(error.to_string()),
            RoadError::Solver(error) => error.into(),
            error @ RoadError::Cancelled => Self::Cancelled(error.to_string()),
            RoadError::Work(message) => Self::Work(message),
        }
    }
}

macro_rules! is_input {
    ($($error:ty),*) => {$(
        impl From<$error> for Ending {
            fn from(error: $error) -> Self {
                Self::Input(error.to_string())
            }
        }
    )*};
}

is_input!(SceneError, DemError, ShapeError, GeometryError, ReportError);

impl From<FormatError> for Ending {
    fn from(error: FormatError) -> Self {
        use std::io::ErrorKind::{QuotaExceeded, StorageFull};
        match &error {
            FormatError::Io { source, .. }
                if matches!(source.kind(), StorageFull | QuotaExceeded) =>
            {
                Self::Work(error.to_string())
            }
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<ClumpError> for Ending {
    fn from(error: ClumpError) -> Self {
        match error {
            ClumpError::NotReached { .. } => Self::Work(error.to_string()),
            ClumpError::Cancelled => Self::Cancelled(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<SolverError> for Ending {
    fn from(error: SolverError) -> Self {
        match error {
            SolverError::Refused { .. } | SolverError::NotFinite { .. } => {
                Self::Work(error.to_string())
            }
            SolverError::Io { .. } | SolverError::Options(_) => Self::Input(error.to_string()),
            _ => Self::Solver(error.to_string()),
        }
    }
}

/// Where verbs print.
pub struct Screen {
    quiet: bool,
    json: bool,
    colour: bool,
    job: Job,
    bar: Arc<Bar>,
    cancelled: Arc<AtomicBool>,
    /// True once something went to standard output.
    printed: AtomicBool,
}

impl Screen {
    /// Sets up colours, progress and Ctrl-C.
    ///
    /// # Errors
    /// A message if the handler of Ctrl-C cannot be set.
    pub fn new(arguments: &Arguments) -> Result<Self, String> {
        let terminal = std::io::stderr().is_terminal();
        let colour = match arguments.color {
            ColorChoice::Always => true,
            ColorChoice::Never => false,
            ColorChoice::Auto => {
                terminal && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
            }
        };
        let cancelled = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&cancelled);
        // The first Ctrl-C asks the work to stop, the second one does not ask.
        ctrlc::set_handler(move || {
            if flag.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        })
        .map_err(|error| format!("cannot watch for Ctrl-C: {error}"))?;
        let threads = arguments.threads.map_or_else(
            || std::thread::available_parallelism().map_or(1, usize::from),
            usize::from,
        );
        // Pictures are drawn on rayon's own pool. It can only be there already, then it serves as well.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        let bar = Arc::new(Bar {
            current: Mutex::new(None),
            shown: terminal && !arguments.quiet,
            quiet: arguments.quiet,
            verbose: arguments.verbose,
        });
        let job = Job::new(threads, Arc::clone(&bar) as _, Arc::clone(&cancelled));
        Ok(Self {
            quiet: arguments.quiet,
            json: arguments.json,
            colour,
            job,
            bar,
            cancelled,
            printed: AtomicBool::new(false),
        })
    }

    /// Surroundings for long work.
    pub fn job(&self) -> Job {
        self.job.clone()
    }

    /// A message on standard error, unless quiet.
    pub fn say(&self, message: &str) {
        self.bar.finished(message);
    }

    /// A warning on standard error, also when quiet.
    pub fn warn(&self, message: &str) {
        self.bar.clear();
        let mark = if self.colour { "\x1b[33;1mwarning\x1b[0m" } else { "warning" };
        let _ = writeln!(std::io::stderr().lock(), "{mark}: {message}");
    }

    /// Says what the road has to remark, and if nothing had to be done.
    pub fn remarks(&self, road: &mut Road) {
        if !road.has_worked() {
            let root = road.store.root().display();
            self.say(&format!("nothing has changed; all is taken from {root}"));
        }
        for remark in road.remarks.drain(..) {
            self.say(&remark);
        }
    }

    /// The result: `value` as JSON if that was asked for, else `text`.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn result(&self, value: &impl serde::Serialize, text: &str) -> Result<(), Ending> {
        if self.json {
            let json = serde_json::to_string_pretty(value)
                .map_err(|error| Ending::Work(error.to_string()))?;
            return self.raw(format!("{json}\n").as_bytes());
        }
        if self.quiet {
            return Ok(());
        }
        self.raw(text.as_bytes())
    }

    /// A text that is the result itself; with JSON asked for, as the string `name` of an object.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn script(&self, name: &str, text: &[u8]) -> Result<(), Ending> {
        if self.json {
            let text = String::from_utf8_lossy(text);
            return self.result(&serde_json::json!({ name: text }), "");
        }
        self.raw(text)
    }

    /// Bytes on standard output.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn raw(&self, bytes: &[u8]) -> Result<(), Ending> {
        self.bar.clear();
        self.printed.store(true, Ordering::Relaxed);
        let mut out = std::io::stdout().lock();
        out.write_all(bytes)?;
        out.flush()?;
        Ok(())
    }

    /// Says how it ended and gives the exit code.
    pub fn close(&self, ending: Result<(), Ending>) -> ExitCode {
        self.bar.clear();
        let (code, message) = match ending {
            Ok(()) | Err(Ending::BrokenPipe) => return ExitCode::SUCCESS,
            Err(Ending::Work(message)) => (1, message),
            Err(Ending::Input(message)) => (2, message),
            Err(Ending::Solver(message)) => (3, message),
            Err(Ending::Cancelled(message)) => (130, message),
        };
        let code = if self.cancelled.load(Ordering::Relaxed) { 130 } else { code };
        let mark = if self.colour { "\x1b[31;1merror\x1b[0m" } else { "error" };
        let _ = writeln!(std::io::stderr().lock(), "{mark}: {message}");
        if self.json && !self.printed.load(Ordering::Relaxed) {
            print_error(code, &message);
        }
        ExitCode::from(code)
    }
}

/// An ending without a result as the one JSON object.
pub fn print_error(code: u8, message: &str) {
    let value = serde_json::json!({ "error": message, "exit_code": code });
    // The exit code says it too, so a closed standard output changes nothing.
    let _ = writeln!(std::io::stdout().lock(), "{value:#}");
}

/// A progress bar that appears with the first report of each kind of work.
struct Bar {
    current: Mutex<Option<(String, ProgressBar)>>,
    shown: bool,
    quiet: bool,
    verbose: bool,
}

impl Bar {
    fn clear(&self) {
        if let Ok(mut current) = self.current.lock()
            && let Some((_, bar)) = current.take()
        {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Bar {
    fn report(&self, what: &str, done: u64, total: u64) {
        if !self.shown {
            return;
        }
        let Ok(mut current) = self.current.lock() else { return };
        if current.as_ref().is_none_or(|(name, _)| name != what) {
            if let Some((_, old)) = current.take() {
                old.finish_and_clear();
            }
            let bar = ProgressBar::new(total);
            if let Ok(style) =
                ProgressStyle::with_template("{msg:>12} {wide_bar} {pos}/{len}  {eta} left")
            {
                bar.set_style(style);
            }
            bar.set_message(what.to_owned());
            *current = Some((what.to_owned(), bar));
        }
        if let Some((_, bar)) = current.as_ref() {
            bar.set_length(total);
            bar.set_position(done);
        }
    }

    fn finished(&self, message: &str) {
        self.clear();
        if !self.quiet {
            // A closed standard error must not end the work.
            let _ = writeln!(std::io::stderr().lock(), "{message}");
        }
    }

    fn detail(&self, message: &str) {
        if self.verbose {
            self.finished(message);
        }
    }
}
