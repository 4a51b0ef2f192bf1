//! Logging of library events to standard error.

use crate::options::RenderOptions;

/// Sets the log level of standard error: with `-v`, each step is logged.
pub fn start(options: &RenderOptions) {
    use tracing_subscriber::EnvFilter;
    let level = if RenderOptions::is(options.verbose) { "dapple=info" } else { "error" };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(level));
    // A second call, from a test, has no effect.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .without_time()
        .try_init();
}
