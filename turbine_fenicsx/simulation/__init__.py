"""Steps in a row, what watches them, and what is kept to go on."""
