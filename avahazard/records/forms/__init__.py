"""The forms of a row, one file each, with the columns of docs/data_forms.md."""
