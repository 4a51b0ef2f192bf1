//! Multiple importance sampling weights, in the ratio form that survives pdfs of 1e±30.
/// Power heuristic (beta = 2) of strategy a against b; pass count·pdf when counts differ.
pub fn power(_pdf_a: f32, _pdf_b: f32) -> f32 {
    todo!()
}
/// Balance heuristic.
pub fn balance(_pdf_a: f32, _pdf_b: f32) -> f32 {
    todo!()
}
