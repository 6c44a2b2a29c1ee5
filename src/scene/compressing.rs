//! Packings that our own DEM compresses: loose random start, compression, back to placements.

use super::preparing::{Lost, laid, shrunk};
use super::road::{Grains, Road, RoadError};
use super::walls::Room;
use crate::dem::compress;
use crate::geometry::Region;
use crate::num::Fault;
use crate::num::units::Pressure;
use crate::pack::compression::{Compression, Until};
use crate::pack::{self, Packing};

/// Largest overlap over the radius that a stress may ask for.
const SOFT: f64 = 0.1;

impl Road {
    /// Packs by compression in the DEM.
    ///
    /// # Errors
    /// A target that grains or contacts cannot have; a start that finds no room; a DEM that cannot run.
    pub(super) fn compressed(
        &self,
        grains: &Grains,
        room: &Room,
        region: &Region,
        wanted: &Compression,
    ) -> Result<Packing, RoadError> {
        let here = |fault: Fault| self.wrong(fault.under("compression").under("packing"));
        wanted.validate().map_err(here)?;
        let dimension = region.dimension() as u32;
        let volume = region.volume();
        let list = super::packing::listed(grains);
        let solid: f64 = list.iter().map(|grain| grain.clump.volume).sum();
        if let Until::Porosity(porosity) = wanted.until {
            pack::possible(&list, region, porosity).map_err(|fault| {
                let fault = Fault { key: "until.porosity".into(), ..fault };
                here(fault)
            })?;
        }
        let first = (wanted.start * volume / solid).powf(1.0 / f64::from(dimension));
        let small = Grains {
            distinct: grains.distinct.iter().map(|grain| shrunk(grain, first, dimension)).collect(),
            copies: grains.copies.clone(),
            key: grains.key.clone(),
        };
        let start = self.loose(&small, room, region).map_err(|lost| match lost {
            Lost::Places(why) => {
                let problem = format!("is {}: {why}", wanted.start);
                here(Fault::new("start", problem, "a smaller solid fraction"))
            }
            Lost::Otherwise(error) => error,
        })?;
        if let Until::Stress(stress) = wanted.until {
            stiff_enough(&start.built.model, stress).map_err(here)?;
        }
        let done = compress(&start.built.model, volume, wanted.start * volume, wanted, &self.job)
            .map_err(RoadError::Dem)?;
        let scale = first * done.scale;
        let placements = laid(&start.packing, &done.states, &list, scale);
        let measures = pack::measure::measure(&placements, &list, region);
        let outcome = format!("{}; all sizes times {scale:.6}", done.outcome);
        if !done.met {
            self.job.finished(&outcome);
        }
        Ok(Packing { placements, dropped: Vec::new(), outcome, measures })
    }
}

/// A fault for a stress that contacts of this stiffness bear with large overlaps only:
/// p ≈ φ Z F / (4 π r²) (Rumpf 1958) with φ Z = 3 gives δ/r = 4 r p/kn.
fn stiff_enough(model: &crate::model::Model, stress: Pressure) -> Result<(), Fault> {
    let largest = model.largest_radius();
    let softest = (0..model.contacts.size() as u16)
        .map(|a| model.contacts.between(a, a).kn)
        .fold(f64::INFINITY, f64::min);
    // Discs of unit thickness: p ≈ φ Z F / (2 π r) gives δ/r = 2 p/kn.
    let overlap = match model.dimension {
        crate::model::Dimension::Three => 4.0 * largest * stress.0 / softest,
        crate::model::Dimension::Two => 2.0 * stress.0 / softest,
    };
    if overlap <= SOFT {
        return Ok(());
    }
    let problem = format!("gives overlaps of about {overlap:.2} of the radius with this contact");
    let allowed = format!("at most {:.3e} Pa, or stiffer contacts", stress.0 * SOFT / overlap);
    Err(Fault::new("until.stress", problem, allowed))
}
