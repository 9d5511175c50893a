"""Constants of nature."""

from __future__ import annotations

#: Standard gravity, m/s².
GRAVITY = 9.80665
