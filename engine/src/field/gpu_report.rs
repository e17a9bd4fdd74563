//! Reports about a GPU: failures, and transferred bytes.

/// Errors of the GPU.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    #[error("no usable GPU adapter: {0}")]
    NoAdapter(String),
    #[error("the GPU refused the work: {0}")]
    Refused(String),
    #[error("the GPU was lost: {0}")]
    Lost(String),
}

/// Traffic to and from the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Bytes read back.
    pub read_back: u64,
    /// Buffers, textures and bind groups created.
    pub allocations: u64,
}
