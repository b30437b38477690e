"""The estimation of a station on live hardware: messages with readings in, messages with estimates and commands out."""
