"""What this extra adds: a kind of documents, by a key that they have."""

DOCUMENTS = {"observation": "an environment for gymnasium.make"}
