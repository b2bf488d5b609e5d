"""A scene: from its YAML file to checked numbers."""
