"""Pictures of recordings: renderings, the shape of a finger, videos. None needs a display."""
