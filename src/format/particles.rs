//! The particle table that all sphere formats share.

use crate::geometry::Bounds;
use crate::num::{Fault, Vec3};

/// Largest id or body number that every format can hold exactly (2⁵³).
pub const LARGEST_NUMBER: u64 = 1 << 53;
/// Largest material number; LAMMPS and LIGGGHTS keep types in 32 bits.
pub const LARGEST_MATERIAL: u32 = i32::MAX as u32 - 1;

/// Largest coordinate and radius, m: their sums and doubles are still finite.
pub const LARGEST_LENGTH: f64 = 1e300;

/// A table with one row a sphere. Columns that are `None` are unknown; those
/// that are there have as many entries as `positions`.
///
/// Ids, bodies and materials count from 0 here. LAMMPS and LIGGGHTS count from
/// 1: their formats add 1 when written and subtract it when read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Particles {
    /// Centres, m.
    pub positions: Vec<Vec3>,
    /// Radii, m, greater than 0.
    pub radii: Vec<f64>,
    /// Numbers of the spheres.
    pub ids: Option<Vec<u64>>,
    /// Number of the rigid body (clump) that each sphere belongs to.
    pub bodies: Option<Vec<u64>>,
    /// Number of the material.
    pub materials: Option<Vec<u32>>,
    /// Density, kg/m³, greater than 0.
    pub densities: Option<Vec<f64>>,
    /// Velocity of the centre, m/s.
    pub velocities: Option<Vec<Vec3>>,
    /// Angular velocity in the world frame, rad/s.
    pub spins: Option<Vec<Vec3>>,
    /// Force on the sphere, N.
    pub forces: Option<Vec<Vec3>>,
    /// Time, s.
    pub time: Option<f64>,
    /// Step number.
    pub step: Option<u64>,
    /// Box of the simulation, m.
    pub bounds: Option<Bounds>,
}

impl Particles {
    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// True if there is no sphere.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// A fault unless all columns have the same length and every value can be
    /// written: finite numbers, positive radii and densities, ids within
    /// [`LARGEST_NUMBER`], a box that is not empty.
    pub fn check(&self) -> Result<(), Fault> {
        let rows = self.len();
        length("radii", Some(self.radii.len()), rows)?;
        length("ids", self.ids.as_ref().map(Vec::len), rows)?;
        length("bodies", self.bodies.as_ref().map(Vec::len), rows)?;
        length("materials", self.materials.as_ref().map(Vec::len), rows)?;
        length("densities", self.densities.as_ref().map(Vec::len), rows)?;
        within("positions", Some(&self.positions), rows, LARGEST_LENGTH)?;
        within("velocities", self.velocities.as_ref(), rows, f64::MAX)?;
        within("spins", self.spins.as_ref(), rows, f64::MAX)?;
        within("forces", self.forces.as_ref(), rows, f64::MAX)?;
        for (key, column) in [("radii", Some(&self.radii)), ("densities", self.densities.as_ref())]
        {
            for (row, value) in column.into_iter().flatten().enumerate() {
                Fault::positive("", *value)
                    .and_then(|()| Fault::within("", *value, 0.0, LARGEST_LENGTH))
                    .map_err(|fault| at(fault, key, row))?;
            }
        }
        for (key, column) in [("ids", &self.ids), ("bodies", &self.bodies)] {
            for (row, value) in column.iter().flatten().enumerate() {
                below("", *value, LARGEST_NUMBER).map_err(|fault| at(fault, key, row))?;
            }
        }
        for (row, value) in self.materials.iter().flatten().enumerate() {
            below("", u64::from(*value), u64::from(LARGEST_MATERIAL))
                .map_err(|fault| at(fault, "materials", row))?;
        }
        if let Some(time) = self.time {
            Fault::within("time", time, f64::MIN, f64::MAX)?;
        }
        below("step", self.step.unwrap_or(0), LARGEST_NUMBER)?;
        match &self.bounds {
            Some(bounds) => check_bounds(bounds),
            None => Ok(()),
        }
    }

    /// The box of the simulation, or the smallest one around all spheres where
    /// it is unknown; a box of no size at the origin for no spheres.
    pub fn extent(&self) -> Bounds {
        if let Some(bounds) = self.bounds {
            return bounds;
        }
        if self.is_empty() {
            return Bounds { low: Vec3::zeros(), high: Vec3::zeros() };
        }
        self.positions.iter().zip(&self.radii).fold(Bounds::EMPTY, |all, (centre, radius)| {
            all.union(&Bounds { low: *centre, high: *centre }.grown(*radius))
        })
    }

    /// True if some body has more than one sphere.
    pub fn has_clumps(&self) -> bool {
        let mut bodies = self.bodies.clone().unwrap_or_default();
        bodies.sort_unstable();
        bodies.windows(2).any(|pair| pair[0] == pair[1])
    }

    /// The same spheres in the order of rising id; as they are where ids are
    /// unknown. Dumps of LAMMPS and LIGGGHTS come unsorted.
    pub fn sorted_by_id(&self) -> Self {
        let Some(ids) = &self.ids else { return self.clone() };
        let mut order: Vec<usize> = (0..self.len()).collect();
        order.sort_by_key(|&row| ids[row]);
        Self {
            positions: picked(&self.positions, &order),
            radii: picked(&self.radii, &order),
            ids: Some(picked(ids, &order)),
            bodies: self.bodies.as_ref().map(|column| picked(column, &order)),
            materials: self.materials.as_ref().map(|column| picked(column, &order)),
            densities: self.densities.as_ref().map(|column| picked(column, &order)),
            velocities: self.velocities.as_ref().map(|column| picked(column, &order)),
            spins: self.spins.as_ref().map(|column| picked(column, &order)),
            forces: self.forces.as_ref().map(|column| picked(column, &order)),
            time: self.time,
            step: self.step,
            bounds: self.bounds,
        }
    }
}

fn picked<T: Copy>(column: &[T], order: &[usize]) -> Vec<T> {
    order.iter().map(|&row| column[row]).collect()
}

fn at(fault: Fault, key: &str, row: usize) -> Fault {
    fault.under(format!("{key}[{row}]"))
}

fn length(key: &str, length: Option<usize>, rows: usize) -> Result<(), Fault> {
    match length {
        Some(length) if length != rows => Err(Fault::new(
            key,
            format!("has {length} entries"),
            format!("{rows} entries, one for each position"),
        )),
        _ => Ok(()),
    }
}

fn within(key: &str, column: Option<&Vec<Vec3>>, rows: usize, largest: f64) -> Result<(), Fault> {
    length(key, column.map(Vec::len), rows)?;
    let wrong = column
        .into_iter()
        .flatten()
        .enumerate()
        .find(|(_, value)| !value.iter().all(|component| component.abs() <= largest));
    match wrong {
        Some((row, value)) => Err(Fault::new(
            format!("{key}[{row}]"),
            format!("is ({}, {}, {})", value.x, value.y, value.z),
            format!("finite numbers up to {largest:e}"),
        )),
        None => Ok(()),
    }
}

fn below(key: &str, value: u64, largest: u64) -> Result<(), Fault> {
    if value <= largest {
        return Ok(());
    }
    Err(Fault::new(key, format!("is {value}"), format!("a whole number up to {largest}")))
}

fn check_bounds(bounds: &Bounds) -> Result<(), Fault> {
    let numbers = bounds.low.iter().chain(bounds.high.iter());
    if numbers.copied().all(|v| v.abs() <= LARGEST_LENGTH) && !bounds.is_empty() {
        return Ok(());
    }
    Err(Fault::new(
        "bounds",
        format!("is {:?} to {:?}", bounds.low.as_slice(), bounds.high.as_slice()),
        "finite corners up to 1e300, the low one not above the high one",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two() -> Particles {
        Particles {
            positions: vec![Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.0, 2.0, 0.0)],
            radii: vec![0.5, 0.25],
            ids: Some(vec![7, 3]),
            ..Particles::default()
        }
    }

    #[test]
    fn faults_name_column_and_row() {
        assert_eq!(two().check(), Ok(()));
        let mut wrong = two();
        wrong.radii[1] = 0.0;
        assert_eq!(wrong.check().map_err(|fault| fault.key), Err("radii[1]".to_owned()));
        let mut wrong = two();
        wrong.velocities = Some(vec![Vec3::zeros(), Vec3::new(0.0, f64::NAN, 0.0)]);
        assert_eq!(wrong.check().map_err(|fault| fault.key), Err("velocities[1]".to_owned()));
        let mut wrong = two();
        wrong.forces = Some(vec![]);
        assert_eq!(wrong.check().map_err(|fault| fault.key), Err("forces".to_owned()));
    }

    #[test]
    fn sorting_moves_whole_rows() {
        let sorted = two().sorted_by_id();
        assert_eq!(sorted.ids, Some(vec![3, 7]));
        assert_eq!(sorted.radii, vec![0.25, 0.5]);
        assert_eq!(sorted.positions[0].y, 2.0);
    }

    #[test]
    fn extent_holds_whole_spheres() {
        let extent = two().extent();
        assert_eq!(extent.low, Vec3::new(-0.5, -0.5, -0.25));
        assert_eq!(extent.high, Vec3::new(0.5, 2.25, 1.5));
    }
}
