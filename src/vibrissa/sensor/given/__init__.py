"""What a person gives of a set-up: values with tolerances, and the rod file that holds them."""
