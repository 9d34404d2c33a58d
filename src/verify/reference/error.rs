//! Why does a reference integration stop?

/// Why an integration stopped.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ReferenceError {
    /// The state became non-finite.
    #[error("the state became non-finite in mesh cycle {cycle}; check the model's parameters")]
    NonFinite {
        /// The mesh cycle.
        cycle: u64,
    },
    /// The contact state changes too often.
    #[error("more than {limit} changes of contact state in mesh cycle {cycle}")]
    Chatter {
        /// The mesh cycle.
        cycle: u64,
        /// The exceeded limit.
        limit: u32,
    },
    /// The extended integrator does not support films of oil.
    #[error("the extended integrator cannot follow a film of oil; remove mesh.film")]
    Film,
    /// The extended integrator does not support rigid stops.
    #[error("the extended integrator cannot follow rigid stops; give them a stiffness")]
    RigidStop,
    /// The extended integrator does not support dry friction.
    #[error("the extended integrator cannot follow dry friction; replace it by a slider")]
    DryFriction,
    /// The trajectory touches a surface so closely that the arithmetic cannot distinguish a touch from a crossing.
    #[error("a surface is touched within the last digit in mesh cycle {cycle}")]
    Touch {
        /// The mesh cycle.
        cycle: u64,
    },
}
