//! `riprap convert`: between all known formats, by extension.

use super::arguments::Convert;
use super::{Ending, Screen};
use crate::format;

pub fn convert(arguments: &Convert, screen: &Screen) -> Result<(), Ending> {
    let report = format::convert(&arguments.input, &arguments.output)?;
    for note in report.not_read.iter().chain(&report.not_written) {
        screen.warn(note);
    }
    screen.result(&report, &format!("{}\n", arguments.output.display()))
}
