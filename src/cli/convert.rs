//! `riprap convert`: between all known formats, by extension.

use super::arguments::Convert;
use super::{Ending, Screen};
use crate::format;

pub fn convert(arguments: &Convert, screen: &Screen) -> Result<(), Ending> {
    let report = format::convert(&arguments.input, &arguments.output)?;
    for lost in &report.lost {
        screen.warn(lost);
    }
    screen.result(&report, &format!("{}\n", arguments.output.display()))
}
