//! Which surfaces emit, and how much.
