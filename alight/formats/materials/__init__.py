"""How files describe surfaces, textures, colours and substances, and what ours are then."""
