//! The form of a grain as methods for any shape see it: its spheres, or its true surface, in the body frame.

use super::Grain;
use super::occupied::clump_radius;
use super::random::Test;
use crate::geometry::{Ball, Mesh, Region};
use crate::num::Fault;
use std::collections::BTreeMap;

/// What a grain is made of.
pub enum Form {
    /// Spheres (discs in two dimensions).
    Balls(Vec<Ball>),
    /// A closed surface.
    Surface(Mesh),
}

/// A form with its sizes.
pub struct Shaped {
    /// In the body frame, m.
    pub form: Form,
    /// Largest distance of any point from the centre of mass, m.
    pub radius: f64,
    /// Volume, m³ (area in two dimensions): of the mesh, or the one that the mass of the clump comes from.
    pub volume: f64,
    /// Diameter of the sphere (disc) of that volume, m.
    pub diameter: f64,
    /// A number that no width of the form is below, m.
    pub narrowest: f64,
}

/// Forms of all grains: each one once, and which one each grain has.
pub struct Forms {
    /// Each form once.
    pub distinct: Vec<Shaped>,
    /// Of each grain, an index into `distinct`.
    pub of: Vec<u32>,
}

impl Forms {
    /// Forms that all find room in `region`, for the method of the key `method`.
    ///
    /// Errors: true shapes in two dimensions, grains larger than the container or half the edge of a periodic box.
    pub fn fitting(
        grains: &[Grain],
        test: Test,
        region: &Region,
        method: &str,
    ) -> Result<Self, Fault> {
        let solids = grains.iter().any(|grain| grain.solid.is_some());
        if region.dimension() == 2 && test == Test::Solid && solids {
            let problem = "is `solid` in two dimensions, where true shapes are the discs of clumps";
            return Err(Fault::new(format!("{method}.test"), problem, "`clump`"));
        }
        let forms = Self::new(grains, test, region.dimension());
        forms.fit(grains, region)?;
        let reach = forms.distinct.iter().map(|shaped| shaped.radius).fold(0.0, f64::max);
        super::fits_its_images(region, reach)?;
        Ok(forms)
    }

    /// Spheres of the clumps, or true surfaces where `test` asks for them and a grain has one. O(n log n).
    pub fn new(grains: &[Grain], test: Test, dimension: usize) -> Self {
        let mut known: BTreeMap<(usize, usize), u32> = BTreeMap::new();
        let mut distinct = Vec::new();
        let of = grains
            .iter()
            .map(|grain| {
                let solid = grain.solid.filter(|_| test == Test::Solid);
                let key = (
                    std::ptr::from_ref(grain.clump).addr(),
                    solid.map_or(0, |solid| std::ptr::from_ref(solid).addr()),
                );
                *known.entry(key).or_insert_with(|| {
                    distinct.push(Shaped::new(grain, test, dimension));
                    distinct.len() as u32 - 1
                })
            })
            .collect();
        Self { distinct, of }
    }

    /// The form of a grain.
    pub fn shaped(&self, grain: usize) -> &Shaped {
        &self.distinct[self.of[grain] as usize]
    }

    /// A fault if some grain is too thick for a container with these edges and this largest clearance, m.
    fn fit(&self, grains: &[Grain], region: &Region) -> Result<(), Fault> {
        let size = region.bounds().size();
        let least = (0..region.dimension()).map(|axis| size[axis]).fold(f64::INFINITY, f64::min);
        for (index, _) in grains.iter().enumerate() {
            let needs = self.shaped(index).narrowest;
            if needs > least * (1.0 + 1e-9) {
                let problem = format!(
                    "fits in no orientation: it is {needs:.4e} m thick or more, the container {least:.4e} m wide"
                );
                let allowed = "a larger container or smaller grains";
                return Err(Fault::new(format!("grains[{index}]"), problem, allowed));
            }
        }
        Ok(())
    }

    /// The smallest equivalent diameter of all grains, m; infinite for none.
    pub fn smallest(&self) -> f64 {
        self.distinct.iter().map(|shaped| shaped.diameter).fold(f64::INFINITY, f64::min)
    }
}

impl Shaped {
    fn new(grain: &Grain, test: Test, dimension: usize) -> Self {
        let sized = |volume: f64| match dimension {
            2 => (4.0 * volume / std::f64::consts::PI).sqrt(),
            _ => (6.0 * volume / std::f64::consts::PI).cbrt(),
        };
        let clump = grain.clump;
        if let Some(solid) = grain.solid.filter(|_| test == Test::Solid) {
            let mesh = solid.mesh.mapped(|v| clump.axes.inverse() * (v - clump.centroid));
            let radius = mesh.vertices.iter().map(|v| v.norm()).fold(0.0, f64::max);
            // A body of width w casts a shadow of at most half its area: V ≤ w A / 2.
            let narrowest = 2.0 * solid.mass.volume / mesh.area();
            let (volume, diameter) = (solid.mass.volume, sized(solid.mass.volume));
            return Self { form: Form::Surface(mesh), radius, volume, diameter, narrowest };
        }
        let narrowest = 2.0 * clump.balls.iter().map(|ball| ball.radius).fold(0.0, f64::max);
        Self {
            form: Form::Balls(clump.balls.clone()),
            radius: clump_radius(grain),
            volume: clump.volume,
            diameter: sized(clump.volume),
            narrowest,
        }
    }

    /// True for a single sphere about the centre of mass, which looks the same however it is turned.
    pub fn is_round(&self) -> bool {
        matches!(&self.form, Form::Balls(balls)
            if balls.len() == 1 && balls[0].centre.norm() <= 1e-12 * self.radius)
    }
}
