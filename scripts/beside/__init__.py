"""What is put beside the bench: a loop built from libraries, a robot in MuJoCo."""
