"""``python -m videovec`` is ``videovec``."""

from videovec.cli import main

if __name__ == "__main__":
    main()
