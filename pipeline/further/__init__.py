"""Further logs for a session that exists: what they are, and the configuration with them."""
