"""The recording for Rerun. Nothing else imports it."""
