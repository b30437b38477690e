"""The live page: its server, its files, and what the thread behind it shares with it."""
