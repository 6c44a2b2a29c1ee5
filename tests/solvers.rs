//! Decks run in the real solvers and held against closed forms and each other.
//! A solver that is not installed is skipped, and the test says so.

mod solvers {
    mod arrivals;
    pub mod bench;
    mod bodies;
    mod discs;
    mod forces;
    mod lammps;
    mod multisphere;
    mod periodic;
    mod restarts;
    mod runs;
    mod springs;
    mod walls;
}
