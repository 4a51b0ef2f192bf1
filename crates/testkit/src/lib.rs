//! Statistics and brute force for tests. Knows none of the other crates: everything comes in as closures and plain numbers.
pub mod chi_square;
pub mod intersect;
pub mod quadrature;
pub mod z_test;
