//! `riprap study`: error against run time.

use super::arguments::Study;
use super::{Ending, Screen};
use crate::study::{self, Effort, StudyError};
use serde_json::json;

impl From<StudyError> for Ending {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Cancelled => Self::Cancelled(error.to_string()),
            StudyError::Input(message) => Self::Input(message),
            StudyError::Work(message) => Self::Work(message),
        }
    }
}

pub fn study(arguments: &Study, screen: &Screen) -> Result<(), Ending> {
    let Some(found) = study::find(&arguments.what) else {
        let keys: Vec<&str> = study::STUDIES.iter().map(|study| study.key).collect();
        let (what, keys) = (&arguments.what, keys.join(", "));
        return Err(Ending::Input(format!("there is no study \"{what}\"; there are: {keys}")));
    };
    let run = match arguments.without_dem {
        true => study::without_dem(found.key).ok_or_else(|| {
            Ending::Input(format!("study {} has no part that --without-dem leaves out", found.key))
        })?,
        false => found.run,
    };
    let folder = arguments.output.clone().unwrap_or_else(|| format!("study-{}", found.key).into());
    // A folder that cannot be made fails before the work.
    std::fs::create_dir_all(&folder)
        .map_err(|error| Ending::Input(format!("{}: cannot write: {error}", folder.display())))?;
    let effort = if arguments.quick { Effort::Quick } else { Effort::Full };
    let findings = run(effort, &screen.job())?;
    let quick = if arguments.quick { " --quick" } else { "" };
    let alone = if arguments.without_dem { " --without-dem" } else { "" };
    let files = findings.write(&folder, &format!("riprap study {}{quick}{alone}", found.key))?;
    screen.say(&format!("wrote {} files into {}", files.len(), folder.display()));
    let value = json!({ "study": found.key, "found": findings.json(), "files": files });
    screen.result(&value, &findings.text())
}
