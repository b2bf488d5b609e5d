"""What a run leaves: tables, summary, folder. Reading needs neither Taichi nor a GPU."""
