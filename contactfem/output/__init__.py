"""Fields, tables, pictures, reports and the terminal."""
