"""Files as they are: encodings, separators, numbers, dates and workbooks, told and read right."""
