"""One stage of the pipeline each: functions from arrays and a frozen config to arrays."""
