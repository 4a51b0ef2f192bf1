//! Which events of the libraries are logged to standard error.

use crate::options::RenderOptions;

/// Sets how much is logged to standard error: with `-v` what is done, step by step.
pub fn start(options: &RenderOptions) {
    use tracing_subscriber::EnvFilter;
    let level = if RenderOptions::is(options.verbose) { "dapple=info" } else { "error" };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(level));
    // A second call, from a test, changes nothing.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .without_time()
        .try_init();
}
