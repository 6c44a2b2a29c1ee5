//! Per-material values that give wanted per-pair values in YADE's ViscElMat.
//!
//! Ip2_ViscElMat_ViscElMat_ViscElPhys combines two materials in series,
//! k = a₁ a₂ / (a₁ + a₂); if one of them is 0 the other is taken unchanged.
//! So the like pair needs aᵢ = 2 kᵢᵢ, and every other pair follows: it either
//! agrees with the scene or YADE cannot express it. Two freedoms are used:
//! walls never meet each other, so a wall's value is only bound by the bodies;
//! and a pair value of 0 can be met by a = 0 or by a value so small that the
//! series is as good as 0.
//!
//! Cost O(2ᶻ n²) for z body materials whose own value is 0 (z ≤ 8, else one try).
//! Comes back with the first pair that cannot be met.

/// Small enough to vanish in any series, large enough not to be 0.
const ALMOST_NOTHING: f64 = 1e-300;
/// Relative difference up to which a pair counts as met: rounding.
const TOLERANCE: f64 = 1e-12;

/// A group of bodies or walls that may have a value of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Class {
    /// Index into `Model::materials`.
    pub material: u16,
    /// Walls of that material rather than bodies.
    pub wall: bool,
    /// Bodies of this class meet each other (there are at least two).
    pub meets_itself: bool,
}

/// A pair that cannot be met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unmet {
    /// First class.
    pub first: usize,
    /// Second class.
    pub second: usize,
    /// Value of the scene.
    pub wanted: f64,
    /// Value that YADE would use.
    pub got: f64,
}

/// The value of each class so that YADE's series of any two classes that meet is `pair(a, b)`.
pub fn solve(classes: &[Class], pair: impl Fn(&Class, &Class) -> f64) -> Result<Vec<f64>, Unmet> {
    let zeros: Vec<usize> = (0..classes.len())
        .filter(|&i| !classes[i].wall && pair(&classes[i], &classes[i]) == 0.0)
        .collect();
    let tries = if zeros.len() <= 8 { 1_u32 << zeros.len() } else { 1 };
    let mut first_fault = None;
    for choice in 0..tries {
        let mut values = vec![0.0; classes.len()];
        for (i, class) in classes.iter().enumerate().filter(|(_, class)| !class.wall) {
            values[i] = own(class, classes, &pair);
        }
        for (bit, &i) in zeros.iter().enumerate() {
            if classes[i].meets_itself || values[i] == 0.0 {
                values[i] = if choice >> bit & 1 == 1 { ALMOST_NOTHING } else { 0.0 };
            }
        }
        for (i, class) in classes.iter().enumerate().filter(|(_, class)| class.wall) {
            values[i] = wall(class, classes, &values, &pair);
        }
        match check(classes, &values, &pair) {
            None => return Ok(values),
            Some(fault) => first_fault = first_fault.or(Some(fault)),
        }
    }
    // A fault was found in every try, and there was at least one.
    Err(first_fault.unwrap_or(Unmet { first: 0, second: 0, wanted: 0.0, got: 0.0 }))
}

/// YADE's combination of two values.
pub fn series(a: f64, b: f64) -> f64 {
    if a == 0.0 {
        b
    } else if b == 0.0 {
        a
    } else {
        1.0 / (1.0 / a + 1.0 / b)
    }
}

/// Twice the value of the like pair. A single body that never meets its like
/// takes the largest value it meets anything with, so that all others can be met.
fn own(class: &Class, classes: &[Class], pair: &impl Fn(&Class, &Class) -> f64) -> f64 {
    let like = pair(class, class);
    let alone = !class.meets_itself && classes.iter().filter(|c| !c.wall).count() == 1;
    if !alone {
        return 2.0 * like;
    }
    let largest = classes.iter().filter(|c| c.wall).map(|c| pair(class, c)).fold(0.0, f64::max);
    2.0 * if largest > 0.0 { largest } else { like }
}

/// The value of a wall class, from the first body class that determines it.
fn wall(
    class: &Class,
    classes: &[Class],
    values: &[f64],
    pair: &impl Fn(&Class, &Class) -> f64,
) -> f64 {
    for (other, a) in classes.iter().zip(values).filter(|(other, _)| !other.wall) {
        let wanted = pair(other, class);
        if wanted == 0.0 && *a > ALMOST_NOTHING {
            return ALMOST_NOTHING;
        }
        if wanted == 0.0 {
            // Any value will do beside a vanishing one, and 0 beside 0.
            continue;
        }
        if *a == 0.0 {
            return wanted;
        }
        if (wanted - a).abs() > TOLERANCE * a && wanted < *a {
            return 1.0 / (1.0 / wanted - 1.0 / a);
        }
    }
    0.0
}

fn check(
    classes: &[Class],
    values: &[f64],
    pair: &impl Fn(&Class, &Class) -> f64,
) -> Option<Unmet> {
    for (i, a) in classes.iter().enumerate() {
        for (j, b) in classes.iter().enumerate().skip(i) {
            let meet = if i == j { a.meets_itself } else { !(a.wall && b.wall) };
            let (wanted, got) = (pair(a, b), series(values[i], values[j]));
            // Against the smallest normal numbers, ALMOST_NOTHING is 0.
            if meet && (wanted - got).abs() > TOLERANCE * wanted + 1e-290 {
                return Some(Unmet { first: i, second: j, wanted, got });
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn body(material: u16) -> Class {
        Class { material, wall: false, meets_itself: true }
    }

    fn wall_of(material: u16) -> Class {
        Class { material, wall: true, meets_itself: false }
    }

    /// Looks values up in a symmetric table.
    fn table<const N: usize>(values: [[f64; N]; N]) -> impl Fn(&Class, &Class) -> f64 {
        move |a, b| values[a.material as usize][b.material as usize]
    }

    #[test]
    fn one_material_is_doubled() {
        assert_eq!(solve(&[body(0), wall_of(0)], table([[5.0]])), Ok(vec![10.0, 10.0]));
    }

    #[test]
    fn walls_have_values_of_their_own() {
        let pairs = table([[5.0, 2.0], [2.0, 99.0]]);
        let values = solve(&[body(0), wall_of(1)], pairs).expect("2 < 10");
        assert!((series(values[0], values[1]) - 2.0).abs() < 1e-14);
        // Twice the like pair is met by a wall value of 0, more by nothing.
        assert_eq!(
            solve(&[body(0), wall_of(1)], table([[5.0, 10.0], [10.0, 1.0]])),
            Ok(vec![10.0, 0.0])
        );
        let stiff = solve(&[body(0), wall_of(1)], table([[5.0, 11.0], [11.0, 1.0]]));
        assert_eq!(stiff, Err(Unmet { first: 0, second: 1, wanted: 11.0, got: 10.0 }));
    }

    #[test]
    fn zeros_are_met() {
        // No dashpot between bodies, one at the wall.
        let values = solve(&[body(0), wall_of(1)], table([[0.0, 3.0], [3.0, 0.0]]));
        assert_eq!(values, Ok(vec![0.0, 3.0]));
        // A dashpot between bodies, none at the wall.
        let values = solve(&[body(0), wall_of(1)], table([[3.0, 0.0], [0.0, 0.0]])).expect("met");
        assert!(series(values[0], values[1]) < 1e-290);
        // Two kinds of bodies: only one kind has a dashpot, and none between them.
        let values = solve(&[body(0), body(1)], table([[3.0, 0.0], [0.0, 0.0]])).expect("met");
        assert!(series(values[0], values[1]) < 1e-290);
        assert_eq!(solve(&[body(0)], table([[0.0]])), Ok(vec![0.0]));
    }

    #[test]
    fn mixed_pairs_must_be_the_harmonic_mean() {
        let good = table([[3.0, 4.0], [4.0, 6.0]]);
        assert!(solve(&[body(0), body(1)], good).is_ok());
        let bad = table([[3.0, 4.5], [4.5, 6.0]]);
        let fault = solve(&[body(0), body(1)], bad).expect_err("not the harmonic mean");
        assert_eq!((fault.first, fault.second, fault.wanted), (0, 1, 4.5));
    }

    #[test]
    fn a_single_body_takes_any_wall() {
        let lone = Class { meets_itself: false, ..body(0) };
        let values = solve(&[lone, wall_of(1)], table([[5.0, 40.0], [40.0, 1.0]])).expect("met");
        assert!((series(values[0], values[1]) - 40.0).abs() < 1e-12);
    }

    proptest! {
        /// Whatever `solve` accepts gives every pair that meets its value.
        #[test]
        fn accepted_values_meet_every_pair(
            own in prop::collection::vec(prop_oneof![Just(0.0), 1e-3..1e9f64], 1..4),
            at_wall in 0.0..1.9f64,
        ) {
            let classes: Vec<Class> = (0..own.len() as u16).map(body)
                .chain([wall_of(own.len() as u16)]).collect();
            let wall_value = 2.0 * own[0] * at_wall;
            let pair = |a: &Class, b: &Class| match (a.wall, b.wall) {
                (false, false) => series(2.0 * own[a.material as usize], 2.0 * own[b.material as usize]),
                (true, true) => 1.0,
                (true, false) => series(2.0 * own[b.material as usize], wall_value),
                (false, true) => series(2.0 * own[a.material as usize], wall_value),
            };
            let values = solve(&classes, pair);
            prop_assert!(values.is_ok(), "{:?}", values);
        }
    }
}
