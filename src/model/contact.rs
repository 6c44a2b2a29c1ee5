//! Contact parameters of pairs of materials.

use serde::{Deserialize, Serialize};

/// Linear spring-dashpot contact with a Coulomb limit (D1), values of the pair,
/// not of one body: Fn = kn δ + cn vn (vn > 0 approaching), Ft from kt, ct, μ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Normal stiffness kn, N/m.
    pub kn: f64,
    /// Tangential stiffness kt, N/m.
    pub kt: f64,
    /// Normal dashpot cn, N s/m.
    pub cn: f64,
    /// Tangential dashpot ct, N s/m.
    pub ct: f64,
    /// Coefficient of friction μ.
    pub friction: f64,
}

/// A symmetric table of contact parameters, materials × materials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ContactTable {
    size: usize,
    entries: Vec<Contact>,
}

impl ContactTable {
    /// The same parameters for every pair of `size` materials.
    pub fn uniform(size: usize, contact: Contact) -> Self {
        Self { size, entries: vec![contact; size * size] }
    }

    /// Number of materials.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Parameters between materials `a` and `b`, in either order.
    pub fn between(&self, a: u16, b: u16) -> &Contact {
        &self.entries[a as usize * self.size + b as usize]
    }

    /// Sets the parameters between `a` and `b`, both ways.
    pub fn set(&mut self, a: u16, b: u16, contact: Contact) {
        self.entries[a as usize * self.size + b as usize] = contact;
        self.entries[b as usize * self.size + a as usize] = contact;
    }
}
