//! Independent integrators for cross-checks; they import `model` only.
