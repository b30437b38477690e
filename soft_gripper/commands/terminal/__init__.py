"""What commands print: tables on the terminal."""
