//! From any format to any other, with a report of what did not survive.

use super::{Data, FormatError, by_extension, format_of, spheres_beside, unknown};
use serde::Serialize;
use std::fmt;
use std::path::Path;

/// What a conversion did.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ConvertReport {
    /// Format that was read.
    pub from: &'static str,
    /// Format that was written.
    pub to: &'static str,
    /// What was converted: "1000 spheres".
    pub content: String,
    /// What of the input was not read, one sentence each.
    pub not_read: Vec<String>,
    /// What was not written, or not known and chosen, one sentence each.
    pub not_written: Vec<String>,
}

impl fmt::Display for ConvertReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} to {}", self.content, self.from, self.to)?;
        self.not_read.iter().chain(&self.not_written).try_for_each(|note| write!(f, "\n  {note}"))
    }
}

/// Reads `input` and writes it as `output`, formats by extension; the input
/// also by its first lines (see [`format_of`]).
///
/// # Errors
/// As [`read`](super::read) and [`write`](super::write); spheres do not become a
/// surface, nor a surface spheres. Where there is an error, `output` is as it was.
pub fn convert(input: &Path, output: &Path) -> Result<ConvertReport, FormatError> {
    let to = by_extension(output).ok_or_else(|| unknown(output))?;
    let input = &spheres_beside(input);
    let from = format_of(input)?;
    let (data, not_read): (Data, _) = (from.read)(input)?;
    let not_written = to.write(output, &data)?;
    Ok(ConvertReport {
        from: from.name,
        to: to.name,
        content: data.summary(),
        not_read,
        not_written,
    })
}
