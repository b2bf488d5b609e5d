"""What the engine can do at most, for those who plan a run without a device."""

from __future__ import annotations

# steps of one launch: software Vulkan drivers skip iterations of long loops; other devices take any length
LONGEST_LAUNCH = {"cpu": 1 << 20, "cuda": 1 << 20, "metal": 1 << 20, "vulkan": 4}
