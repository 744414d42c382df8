"""Many models: jobs, where they run, what came of them."""
