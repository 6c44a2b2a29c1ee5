//! The cheapest clump that is as near to its solid as asked for: sphere counts
//! rise by about √2 from 5 to 1 280 until the RMS distance of the surfaces is
//! small enough. Cost: the sum over the ladder, about 3.4 times its last rung.
//! `fitted` looks for the fewest spheres itself and is asked once.

use super::{Clump, ClumpError, Fitted, METHODS, MassSource, Method, reproduce};
use crate::num::{Fault, Job};
use crate::shape::Solid;

/// Largest numbers of spheres that are tried, one after the other.
const LADDER: [u32; 17] =
    [5, 7, 10, 14, 20, 28, 40, 56, 80, 113, 160, 226, 320, 452, 640, 905, 1280];

/// Keys of the methods that can be asked for a number of spheres.
pub fn counted() -> impl Iterator<Item = &'static str> {
    METHODS.iter().map(|entry| entry.key).filter(|key| Method::with_spheres(key, 20).is_some())
}

impl Method {
    /// The method called `key` with at most `spheres` spheres and otherwise its defaults.
    ///
    /// # Errors
    /// [`ClumpError::Input`] if there is no such method.
    pub fn by_key(key: &str, spheres: u32) -> Result<Self, ClumpError> {
        Self::with_spheres(key, spheres).ok_or_else(|| {
            let known: Vec<&str> = counted().collect();
            let allowed = format!("one of {}", known.join(", "));
            ClumpError::Input(Fault::new("method", format!("is \"{key}\""), allowed))
        })
    }
}

/// The first clump of `solid` on the ladder whose RMS surface distance is at
/// most `error` of the equivalent diameter, by the method called `method`.
///
/// # Errors
/// [`ClumpError::Input`] for an unknown method or an error outside (0, 1);
/// [`ClumpError::NotReached`] with the best error if no rung is near enough;
/// as [`reproduce`] otherwise.
pub fn reproduce_to_error(
    solid: &Solid,
    method: &str,
    error: f64,
    job: &Job,
) -> Result<Clump, ClumpError> {
    if !(error > 0.0 && error < 1.0) {
        let allowed = "greater than 0, less than 1";
        return Err(Fault::new("error", format!("is {error}"), allowed).into());
    }
    let mut best = f64::INFINITY;
    if method == "fitted" {
        let spheres = LADDER[LADDER.len() - 1] as usize;
        let fewest = Fitted { spheres, error: Some(error), ..Fitted::default() };
        let clump = reproduce(solid, &Method::Fitted(fewest), MassSource::Solid, 0, 0, job)?;
        let best = clump.fidelity.map_or(0.0, |f| f.rms_distance / f.equivalent_diameter);
        // Measured with more points than the search: equal but for their scatter.
        if best > 1.02 * error {
            return Err(ClumpError::NotReached { method: method.to_owned(), error, best });
        }
        return Ok(clump);
    }
    for spheres in LADDER {
        if job.is_cancelled() {
            return Err(ClumpError::Cancelled);
        }
        let method = Method::by_key(method, spheres)?;
        let clump = reproduce(solid, &method, MassSource::Solid, 0, 0, job)?;
        let reached = clump.fidelity.map_or(0.0, |f| f.rms_distance / f.equivalent_diameter);
        if reached <= error {
            return Ok(clump);
        }
        best = best.min(reached);
    }
    Err(ClumpError::NotReached { method: method.to_owned(), error, best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;

    #[test]
    fn a_smaller_error_needs_more_spheres_and_nonsense_is_refused() {
        let mesh = Primitive::Ellipsoid { axes: crate::num::Vec3::new(1.0, 0.8, 0.6) }.mesh(12);
        let mass = mesh.mass_properties();
        let solid = Solid { name: "egg".into(), mesh, mass, recipe: String::new() };
        let job = Job::quiet();
        let rough = reproduce_to_error(&solid, "normals", 0.1, &job).expect("a clump");
        let fine = reproduce_to_error(&solid, "normals", 0.02, &job).expect("a clump");
        let rms = |clump: &Clump| clump.fidelity.map(|f| f.rms_distance / f.equivalent_diameter);
        assert!(rms(&rough) <= Some(0.1) && rms(&fine) <= Some(0.02));
        assert!(rough.balls.len() < fine.balls.len());
        for wrong in [0.0, 1.0, f64::NAN] {
            assert!(reproduce_to_error(&solid, "normals", wrong, &job).is_err(), "{wrong}");
        }
        let fitted = reproduce_to_error(&solid, "fitted", 0.02, &job).expect("a clump");
        assert!(rms(&fitted) <= Some(0.0205) && fitted.balls.len() < fine.balls.len());
        assert!(Method::by_key("none", 5).is_err());
    }
}
