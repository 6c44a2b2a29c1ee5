//! Convex hulls, by parry3d (quickhull).

use super::error::GeometryError;
use super::{Mesh, topology};
use crate::num::Vec3;
use parry3d::math::Vec3 as Point;
use parry3d::transformation::try_convex_hull;

/// The convex hull of `points` as a closed mesh; an error for points in a plane.
///
/// Cost about O(n log n). The result is checked: closed, and no point outside
/// by more than 1e-6 of its size.
pub fn convex_hull(points: &[Vec3]) -> Result<Mesh, GeometryError> {
    let refused = |reason: String| GeometryError::NoHull { reason };
    let given: Vec<Point> = points.iter().map(|p| Point::new(p.x, p.y, p.z)).collect();
    let (vertices, triangles) =
        try_convex_hull(&given).map_err(|error| refused(error.to_string()))?;
    let mesh =
        Mesh { vertices: vertices.iter().map(|p| Vec3::new(p.x, p.y, p.z)).collect(), triangles };
    let report = topology::inspect(&mesh);
    if report.open_edges + report.crowded_edges + report.misoriented_edges > 0
        || report.volume <= 0.0
    {
        return Err(refused("the points lie in a plane or nearly so".to_owned()));
    }
    // Of very many points and faces an even share is checked: some 10^8 distances.
    let stride = 1 + (points.len() as f64 * mesh.triangles.len() as f64 / 1e8) as usize;
    let checked: Vec<Vec3> = points.iter().step_by(stride).copied().collect();
    let outside = furthest_outside(&mesh, &checked);
    if outside > 1e-6 * mesh.bounds().diagonal() {
        return Err(refused(format!("a point lies {outside:e} m outside the result")));
    }
    Ok(mesh)
}

/// The largest distance of a point beyond the plane of a face.
fn furthest_outside(hull: &Mesh, points: &[Vec3]) -> f64 {
    hull.facets()
        .filter_map(|[a, b, c]| {
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
            let level = normal.dot(&a);
            // Needle faces have no reliable plane.
            let height = (b - a).cross(&(c - a)).norm() / (b - a).norm().max((c - a).norm());
            (height > 1e-6 * (b - a).norm().max((c - a).norm()))
                .then(|| points.iter().map(|p| normal.dot(p) - level).fold(0.0, f64::max))
        })
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::num::random;

    #[test]
    fn hull_of_a_box_with_points_inside() {
        let mut source = random::stream(2, "hull", 0);
        let mut points = Primitive::Box { edges: Vec3::new(1.0, 2.0, 3.0) }.mesh(3).vertices;
        points.extend((0..200).map(|_| random::direction(&mut source) * 0.4));
        let hull = convex_hull(&points).expect("points in space");
        assert!((hull.mass_properties().volume - 6.0).abs() < 1e-12);
        assert_eq!(hull.vertices.len(), 8);
    }

    #[test]
    fn hull_of_a_convex_mesh_is_the_mesh() {
        let mut source = random::stream(3, "hull", 0);
        for solid in [
            Primitive::Ellipsoid { axes: Vec3::new(1.0, 2.0, 0.5) },
            Primitive::Cylinder { diameter: 1.0, height: 1.0 },
            Primitive::Cone { diameter: 1.0, height: 1.0 },
        ] {
            let turn = random::rotation(&mut source);
            let mesh = solid.mesh(40).mapped(|p| turn * p);
            let hull = convex_hull(&mesh.vertices).expect("points in space");
            let ratio = hull.mass_properties().volume / mesh.mass_properties().volume;
            assert!((ratio - 1.0).abs() < 1e-9, "{solid:?} {ratio}");
        }
    }

    #[test]
    fn points_in_a_plane_have_none() {
        let flat: Vec<Vec3> =
            (0..9).map(|i| Vec3::new((i % 3) as f64, (i / 3) as f64, 0.0)).collect();
        assert!(convex_hull(&flat).is_err());
        assert!(convex_hull(&[]).is_err());
    }
}
