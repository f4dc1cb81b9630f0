"""What a lecturer runs on submissions and questions."""
