"""The workspace: artifacts as files, a manifest, a lock, resume."""
