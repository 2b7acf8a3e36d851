"""MIDI: notes for key frames, clock for the tempo of repetitions."""
