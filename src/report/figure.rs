//! A chart or picture as the page templates take it.

use super::ReportError;
use super::chart::{Bars, Chart};
use super::picture::Picture;
use crate::format::base64;
use serde::Serialize;

/// A chart or picture.
#[derive(Serialize)]
pub struct Figure {
    title: String,
    caption: String,
    /// An `<svg>` element; empty for pictures.
    svg: String,
    /// A data URI; empty for charts.
    png: String,
}

impl Figure {
    /// A chart; `None` if it has nothing to draw.
    pub fn chart(chart: &Chart) -> Option<Self> {
        let (title, caption) = (chart.title.clone(), chart.caption.clone());
        Some(Self { title, caption, svg: chart.svg()?, png: String::new() })
    }

    /// A chart of bars; `None` if it has nothing to draw.
    pub fn bars(bars: &Bars) -> Option<Self> {
        let (title, caption) = (bars.title.clone(), bars.caption.clone());
        Some(Self { title, caption, svg: bars.svg()?, png: String::new() })
    }

    /// A picture.
    ///
    /// # Errors
    /// A picture that cannot be encoded.
    pub fn picture(picture: &Picture, title: &str, caption: &str) -> Result<Self, ReportError> {
        let png = format!("data:image/png;base64,{}", base64::encode(&picture.png()?));
        Ok(Self { title: title.into(), caption: caption.into(), svg: String::new(), png })
    }
}
