//! Rows of numbers to particle tables and back: what the text formats share.

use super::number::push_number;
use super::particles::{LARGEST_LENGTH, LARGEST_MATERIAL, LARGEST_NUMBER, Particles};
use crate::num::Vec3;

/// What one column of a table holds; the number of a vector is its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Field {
    Id,
    Body,
    Material,
    Position(usize),
    Radius,
    Diameter,
    Density,
    Velocity(usize),
    Spin(usize),
    Force(usize),
    /// A column that is not understood, or not wanted.
    Other,
}

impl Field {
    /// The columns that `particles` has, in the order of our tables.
    pub(super) fn present(particles: &Particles) -> Vec<Self> {
        let vector = |known: bool, field: fn(usize) -> Self| {
            (0..3).filter(move |_| known).map(field).collect::<Vec<_>>()
        };
        let scalar = |known: bool, field: Self| known.then_some(field);
        let mut fields = Vec::new();
        fields.extend(scalar(particles.ids.is_some(), Self::Id));
        fields.extend(scalar(particles.bodies.is_some(), Self::Body));
        fields.extend(scalar(particles.materials.is_some(), Self::Material));
        fields.extend(vector(true, Self::Position));
        fields.push(Self::Radius);
        fields.extend(vector(particles.velocities.is_some(), Self::Velocity));
        fields.extend(vector(particles.spins.is_some(), Self::Spin));
        fields.extend(vector(particles.forces.is_some(), Self::Force));
        fields.extend(scalar(particles.densities.is_some(), Self::Density));
        fields
    }

    /// Puts the value of this column in `row` at the end of `out`; numbers that
    /// count things are raised by `first`. Unknown ids, bodies and materials
    /// print as the row number, the row number and 0; other unknown values as 0.
    pub(super) fn push(self, out: &mut String, particles: &Particles, row: usize, first: u64) {
        let whole = |column: &Option<Vec<u64>>| column.as_ref().map_or(row as u64, |c| c[row]);
        let component =
            |column: &Option<Vec<Vec3>>, axis: usize| column.as_ref().map_or(0.0, |c| c[row][axis]);
        let value = match self {
            Self::Id => return push_whole(out, whole(&particles.ids) + first),
            Self::Body => return push_whole(out, whole(&particles.bodies) + first),
            Self::Material => {
                let material = particles.materials.as_ref().map_or(0, |c| c[row]);
                return push_whole(out, u64::from(material) + first);
            }
            Self::Position(axis) => particles.positions[row][axis],
            Self::Radius => particles.radii[row],
            Self::Diameter => 2.0 * particles.radii[row],
            Self::Density => particles.densities.as_ref().map_or(0.0, |c| c[row]),
            Self::Velocity(axis) => component(&particles.velocities, axis),
            Self::Spin(axis) => component(&particles.spins, axis),
            Self::Force(axis) => component(&particles.forces, axis),
            Self::Other => 0.0,
        };
        push_number(out, value);
    }
}

fn push_whole(out: &mut String, value: u64) {
    out.push_str(&value.to_string());
}

/// Puts one row at the end of `out`, columns parted by `separator`, with a line end.
pub(super) fn push_row(
    out: &mut String,
    fields: &[Field],
    separator: char,
    particles: &Particles,
    row: usize,
    first: u64,
) {
    for (place, field) in fields.iter().enumerate() {
        if place > 0 {
            out.push(separator);
        }
        field.push(out, particles, row, first);
    }
    out.push('\n');
}

/// Reads a finite number.
pub(super) fn real(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("`{}` is not finite", shown(text))),
        Err(_) => Err(format!("`{}` is not a number", shown(text))),
    }
}

/// Reads a whole number from 0 to 2⁵³.
pub(super) fn whole(text: &str) -> Result<u64, String> {
    match text.parse::<u64>() {
        Ok(value) if value <= LARGEST_NUMBER => Ok(value),
        _ => Err(format!("`{}` is not a whole number from 0 to {LARGEST_NUMBER}", shown(text))),
    }
}

/// The beginning of `text`, fit for one line of a message.
pub(super) fn shown(text: &str) -> String {
    let mut short: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() {
        short.push('…');
    }
    short
}

/// Collects rows of text cells into a particle table.
pub(super) struct Rows {
    fields: Vec<Field>,
    first: u64,
    /// Rows whose body is "none": molecule 0 or −1 in files of LAMMPS and LIGGGHTS.
    alone: Vec<usize>,
    particles: Particles,
}

impl Rows {
    /// Rows with these columns; ids, bodies and materials in the text count
    /// from `first` (0 or 1). An error if a needed column is missing or one
    /// comes twice; `name` says how the format calls a column.
    pub(super) fn new(
        fields: Vec<Field>,
        first: u64,
        name: impl Fn(Field) -> String,
    ) -> Result<Self, String> {
        let has = |field: Field| fields.contains(&field);
        for (place, field) in fields.iter().enumerate() {
            if *field != Field::Other && fields[..place].contains(field) {
                return Err(format!("column `{}` comes twice", name(*field)));
            }
        }
        if has(Field::Radius) && has(Field::Diameter) {
            return Err("radius and diameter are both there; one must go".to_owned());
        }
        let mut missing: Vec<Field> = (0..3).map(Field::Position).filter(|f| !has(*f)).collect();
        if !has(Field::Radius) && !has(Field::Diameter) {
            missing.push(Field::Radius);
        }
        for vector in [Field::Velocity, Field::Spin, Field::Force] {
            if (0..3).any(|axis| has(vector(axis))) {
                missing.extend((0..3).map(vector).filter(|f| !has(*f)));
            }
        }
        if !missing.is_empty() {
            let names: Vec<String> = missing.into_iter().map(name).collect();
            return Err(format!("missing column {}", names.join(", ")));
        }
        let particles = Particles {
            ids: has(Field::Id).then(Vec::new),
            bodies: has(Field::Body).then(Vec::new),
            materials: has(Field::Material).then(Vec::new),
            densities: has(Field::Density).then(Vec::new),
            velocities: has(Field::Velocity(0)).then(Vec::new),
            spins: has(Field::Spin(0)).then(Vec::new),
            forces: has(Field::Force(0)).then(Vec::new),
            ..Particles::default()
        };
        Ok(Self { fields, first, alone: Vec::new(), particles })
    }

    /// Number of columns.
    pub(super) fn columns(&self) -> usize {
        self.fields.len()
    }

    /// Adds one row, which must have exactly one cell a column.
    pub(super) fn add<'a>(&mut self, cells: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let mut row = Row::default();
        let mut found = 0;
        for cell in cells {
            match self.fields.get(found) {
                // LIGGGHTS prints id_multisphere -1 for spheres of no clump.
                Some(Field::Body) if self.first == 1 && cell == "-1" => row.body = 0,
                Some(field) => row.take(*field, cell)?,
                None => {}
            }
            found += 1;
        }
        if found != self.fields.len() {
            return Err(format!("{found} values in a table of {} columns", self.fields.len()));
        }
        self.put(row)
    }

    fn put(&mut self, row: Row) -> Result<(), String> {
        let Self { first, particles, alone, .. } = self;
        let counted = |value: u64, what: &str| {
            value
                .checked_sub(*first)
                .ok_or_else(|| format!("{what} is {value}; this format counts from {first}"))
        };
        if row.radius <= 0.0 {
            return Err(format!("radius is {}; it must be greater than 0", row.radius));
        }
        if row.position.amax().max(row.radius).max(row.density) > LARGEST_LENGTH {
            return Err(format!("a value is above {LARGEST_LENGTH:e}"));
        }
        if let Some(column) = &mut particles.densities {
            if row.density <= 0.0 {
                return Err(format!("density is {}; it must be greater than 0", row.density));
            }
            column.push(row.density);
        }
        if let Some(column) = &mut particles.materials {
            let material = counted(row.material, "material (type)")?;
            let small = u32::try_from(material).ok().filter(|m| *m <= LARGEST_MATERIAL);
            column.push(
                small.ok_or_else(|| format!("material {material} is above {LARGEST_MATERIAL}"))?,
            );
        }
        if let Some(column) = &mut particles.ids {
            column.push(counted(row.id, "id")?);
        }
        if let Some(column) = &mut particles.bodies {
            if row.body < *first {
                alone.push(column.len());
            }
            column.push(row.body.saturating_sub(*first));
        }
        for (column, value) in [
            (&mut particles.velocities, row.velocity),
            (&mut particles.spins, row.spin),
            (&mut particles.forces, row.force),
        ] {
            if let Some(column) = column {
                column.push(value);
            }
        }
        particles.positions.push(row.position);
        particles.radii.push(row.radius);
        Ok(())
    }

    /// The table. Spheres of molecule 0, which move alone, become bodies of
    /// their own, numbered after all others.
    pub(super) fn finish(self) -> Particles {
        let Self { alone, mut particles, .. } = self;
        if let Some(bodies) = &mut particles.bodies
            && !alone.is_empty()
        {
            let mut apart = alone.iter().copied().peekable();
            let largest = bodies
                .iter()
                .enumerate()
                .filter(|(row, _)| apart.next_if_eq(row).is_none())
                .map(|(_, body)| body + 1)
                .max();
            for (next, row) in (largest.unwrap_or(0)..).zip(&alone) {
                bodies[*row] = next;
            }
        }
        particles
    }
}

/// One row while it is read.
#[derive(Default)]
struct Row {
    id: u64,
    body: u64,
    material: u64,
    position: Vec3,
    radius: f64,
    density: f64,
    velocity: Vec3,
    spin: Vec3,
    force: Vec3,
}

impl Row {
    fn take(&mut self, field: Field, cell: &str) -> Result<(), String> {
        match field {
            Field::Id => self.id = whole(cell)?,
            Field::Body => self.body = whole(cell)?,
            Field::Material => self.material = whole(cell)?,
            Field::Position(axis) => self.position[axis] = real(cell)?,
            Field::Radius => self.radius = real(cell)?,
            Field::Diameter => self.radius = 0.5 * real(cell)?,
            Field::Density => self.density = real(cell)?,
            Field::Velocity(axis) => self.velocity[axis] = real(cell)?,
            Field::Spin(axis) => self.spin[axis] = real(cell)?,
            Field::Force(axis) => self.force[axis] = real(cell)?,
            Field::Other => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(field: Field) -> String {
        format!("{field:?}")
    }

    #[test]
    fn half_a_vector_is_an_error() {
        use Field::{Position, Radius, Velocity};
        let fields = vec![Position(0), Position(1), Position(2), Radius, Velocity(1)];
        let error = Rows::new(fields, 0, named).map(|_| ()).expect_err("two components missing");
        assert_eq!(error, "missing column Velocity(0), Velocity(2)");
    }

    #[test]
    fn molecule_zero_moves_alone() {
        use Field::{Body, Position, Radius};
        let fields = vec![Body, Position(0), Position(1), Position(2), Radius];
        let mut rows = Rows::new(fields, 1, named).expect("all there");
        for line in ["0 0 0 0 1", "5 1 0 0 1", "-1 2 0 0 1", "5 3 0 0 1"] {
            rows.add(line.split(' ')).expect("a good row");
        }
        assert_eq!(rows.finish().bodies, Some(vec![5, 4, 6, 4]));
    }

    #[test]
    fn rows_that_do_not_fit_are_refused() {
        use Field::{Id, Position, Radius};
        let fields = vec![Id, Position(0), Position(1), Position(2), Radius];
        let mut rows = Rows::new(fields, 1, named).expect("all there");
        for (line, part) in [
            ("1 0 0 0", "4 values in a table of 5 columns"),
            ("1 0 0 0 1 1", "6 values"),
            ("0 0 0 0 1", "counts from 1"),
            ("1 0 0 0 0", "greater than 0"),
            ("1 0 nan 0 1", "not finite"),
            ("1 0 x 0 1", "`x` is not a number"),
            ("-1 0 0 0 1", "whole number"),
        ] {
            let error = rows.add(line.split(' ')).expect_err(line);
            assert!(error.contains(part), "{line}: {error}");
        }
        assert!(rows.finish().is_empty());
    }
}
