"""`python -m cabledrive` is the command `cabledrive`."""

from cabledrive.app.main import main

if __name__ == "__main__":
    main()
