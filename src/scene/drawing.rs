//! Surfaces as their methods draw them, valid grains or not.

use super::grains;
use super::road::{Road, RoadError};
use super::statistics::write_facts;
use super::store::key;
use crate::format;
use crate::shape::Fact;
use serde::Serialize;
use serde_json::json;
use std::io::Write;

/// One surface as it was drawn.
#[derive(Debug, Serialize)]
pub struct Verdict {
    /// Name of the grain.
    pub name: String,
    /// Why it is no valid grain; `None` if it is one.
    pub fault: Option<String>,
    /// How it was made.
    pub recipe: String,
    /// Its statistics.
    pub facts: Vec<Fact>,
}

impl Road {
    /// The first draw of every distinct grain as it comes, in `as-drawn/`, with
    /// `verdicts.csv` (valid grain or why not) and `statistics.csv`.
    ///
    /// # Errors
    /// A method that draws nothing; a folder that cannot be written.
    pub fn as_drawn(&mut self) -> Result<Vec<Verdict>, RoadError> {
        let draws = grains::draws(&self.loaded).map_err(|fault| self.wrong(fault))?;
        let mut running =
            self.store.begin("as-drawn", &key("", &[json!("always anew")], self.loaded.base()))?;
        let mut verdicts = Vec::new();
        for (count, draw) in draws.iter().enumerate() {
            if self.job.is_cancelled() {
                return Err(RoadError::Cancelled);
            }
            let first = grains::as_drawn(&self.loaded, draw).map_err(|fault| self.wrong(fault))?;
            let Some((drawn, fault)) = first else { continue };
            let file = format!("as-drawn/{}.stl", draw.name);
            let path = self.store.prepare(&mut running, &file)?;
            format::stl::write(&path, &drawn.mesh)?;
            verdicts.push(Verdict {
                name: draw.name.clone(),
                fault: fault.map(|fault| fault.to_string()),
                recipe: drawn.recipe,
                facts: drawn.facts,
            });
            self.job.report("surfaces", count as u64 + 1, draws.len() as u64);
        }
        self.store.write(&mut running, "as-drawn/verdicts.csv", |out| {
            writeln!(out, "name,valid,reason,recipe")?;
            for v in &verdicts {
                let quoted = |text: &str| text.replace('"', "'");
                let reason = quoted(v.fault.as_deref().unwrap_or(""));
                let valid = v.fault.is_none();
                writeln!(out, "{},{valid},\"{reason}\",\"{}\"", v.name, quoted(&v.recipe))?;
            }
            Ok(())
        })?;
        let facts: Vec<_> = verdicts.iter().map(|v| (v.name.as_str(), &v.facts[..])).collect();
        self.store
            .write(&mut running, "as-drawn/statistics.csv", |out| write_facts(out, &facts))?;
        running.count("surfaces", verdicts.len());
        let made = format!("drew {} surfaces", verdicts.len());
        self.close(running, &made)?;
        Ok(verdicts)
    }
}
