"""What is written and shown while a run goes on: recording, trajectory, time series, progress."""
