"""Reports as HTML: charts, pictures, tables and a 3D view in one file that needs no network."""
