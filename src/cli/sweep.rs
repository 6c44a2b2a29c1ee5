//! `riprap sweep`: many cases of one scene.

use super::arguments::Sweep as Arguments;
use super::{Ending, Screen};
use crate::format::atomic;
use crate::sweep::cases::cases;
use crate::sweep::work::{Status, Work};
use crate::sweep::{Stage, Sweep, SweepError, summary};
use serde_json::json;
use std::io::Write;

impl From<SweepError> for Ending {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Scene(_) | SweepError::Case { .. } | SweepError::Folder(_) => {
                Self::Input(error.to_string())
            }
            SweepError::File(error) => error.into(),
            SweepError::Report(error) => error.into(),
            SweepError::Cancelled { .. } => Self::Cancelled(error.to_string()),
        }
    }
}

pub fn sweep(arguments: &Arguments, screen: &Screen) -> Result<(), Ending> {
    let path = &arguments.sweep;
    let sweep = Sweep::read(path)?;
    let root = arguments.output.clone().unwrap_or_else(|| path.with_extension("out"));
    let cases = cases(&sweep, path, &root)?;
    if sweep.stage == Stage::Compare {
        super::compare::chosen(&sweep.solvers, screen)?;
    }
    let job = screen.job();
    let at_once = arguments.jobs.map_or(job.threads, usize::from).min(cases.len());
    std::fs::create_dir_all(&root)
        .map_err(|error| Ending::Input(format!("{}: cannot write: {error}", root.display())))?;
    let work = Work { sweep: &sweep, cases: &cases, root: &root, at_once, job: &job };
    if arguments.write_only {
        for case in &cases {
            std::fs::create_dir_all(work.folder(case))?;
            atomic::write(&work.folder(case).join("scene.toml"), |out| {
                out.write_all(case.text.as_bytes())
            })?;
        }
        summary::write_array(sweep.stage, &cases, &root)?;
        let text = format!("{} cases in {}\n", cases.len(), root.display());
        return screen.result(&json!({ "cases": cases.len(), "output": root }), &text);
    }
    let records = work.all(arguments.resume)?;
    let command = format!("riprap sweep {}", path.display());
    summary::write_array(sweep.stage, &cases, &root)?;
    let findings = summary::write(&sweep, &records, &root, &command)?;
    let failed: Vec<&str> =
        records.iter().filter(|r| r.status != Status::Done).map(|r| r.case.as_str()).collect();
    let text = format!("{}\n{}\n", findings.remarks.join("\n"), root.join("index.html").display());
    let json = json!({ "output": root, "cases": records.len(), "failed": failed });
    screen.result(&json, &text)?;
    if failed.is_empty() {
        return Ok(());
    }
    let (count, all) = (failed.len(), records.len());
    Err(Ending::Work(format!(
        "{count} of {all} cases did not end as they should; see manifest.csv"
    )))
}
