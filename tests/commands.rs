//! The program as people call it: every verb, its files, messages and exit codes.

mod commands {
    pub mod bench;
    mod outside;
    mod scenes;
    mod stages;
    mod studies;
    mod sweeps;
    mod tools;
}
