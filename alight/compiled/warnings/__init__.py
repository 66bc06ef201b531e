"""What is legal but suspicious of a scene, where only its tables tell: what is said about it."""
