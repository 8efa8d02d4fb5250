"""The verification book: rows, sections, chapters, and the page that is made of them."""
