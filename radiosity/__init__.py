"""Radiosity that reaches the accuracy you ask for and says what it reached."""
